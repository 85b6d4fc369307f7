// SPDX-License-Identifier: BSD-2-Clause
// A copy of a map, brought up to date by what has changed, for whoever shows or writes it while the
// run goes on.
#pragma once

#include <optional>
#include <set>
#include <vector>

#include "facet/mesh/surface_map.h"

namespace facet {

/// Not thread-safe.
class MapFollower {
 public:
  explicit MapFollower(const SurfaceMapOptions& options) : map_(options) {}

  /// What SurfaceMap::TakeChanged of the map gave.
  void Take(const std::vector<SurfaceMap::Block>& blocks);

  struct Part {
    CubeIndex index;
    TriangleMesh mesh;  ///< empty where there is nothing any more
  };
  /// Extracts one of the parts whose surface may have changed; empty when all were taken.
  std::optional<Part> TakePart();

  /// All parts are to be extracted again, for whoever begins to listen.
  void MarkAll();

  bool has_changed() const { return !changed_.empty(); }

 private:
  void Mark(const CubeIndex& block);

  SurfaceMap map_;
  std::set<CubeIndex> changed_;
};

}  // namespace facet
