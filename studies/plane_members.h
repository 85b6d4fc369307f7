// SPDX-License-Identifier: BSD-2-Clause
// How far the landmarks that a run holds on its planes truly are from them.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "true_scene.h"

#include "facet/io/planes_file.h"
#include "facet/map/map_snapshot.h"

namespace facet {

/// Counts each landmark of a plane once. A plane of the run is the true one that most of its
/// landmarks are on.
class PlaneMembers {
 public:
  /// Reads truth/planes.csv. Throws InputError.
  explicit PlaneMembers(const std::filesystem::path& sequence);

  /// The estimate after a keyframe.
  void Add(const MapSnapshot& map);

  /// Where a landmark was seen first; one without such a point does not count.
  using PointOf = std::function<const ScenePoint*(LandmarkId)>;
  void Print(const PointOf& point_of) const;

 private:
  /// Rows of planes.csv (-1: no plane) and how many members lie on each, the most first.
  static std::vector<std::pair<int, int>> TrueSurfacesOf(const std::vector<ScenePoint>& members);
  void PrintPlane(PlaneId id, const std::vector<std::pair<int, int>>& surfaces) const;

  std::vector<TruePlane> planes_G_;
  std::map<PlaneId, std::set<LandmarkId>> members_;
};

}  // namespace facet
