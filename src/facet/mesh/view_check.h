// SPDX-License-Identifier: BSD-2-Clause
// Does a face of the horizon mesh agree with what the newest keyframe sees? (What the paper leaves
// open in II-A.2: occlusion, overlapping and contradictory faces.)
#pragma once

#include <array>
#include <vector>

#include "facet/mesh/mesh_options.h"
#include "facet/mesh/mesh_view.h"

namespace facet {

/// A face as a camera sees it: places on the plane z = 1 and inverse depths, which are linear over
/// the face.
struct ProjectedFace {
  std::array<Vector2d, 3> xy;
  std::array<double, 3> inverse_depth{};
};

/// Empty result (false) when a corner is not in front of the camera.
bool ProjectFace(const std::array<Vector3d, 3>& p_C, ProjectedFace& face);

/// What the view says about an old face.
struct FaceSighting {
  bool is_replaced = false;  ///< newer faces cover it
  int votes_against = 0;     ///< sightings through it
};

/// A coarse depth image of the newest keyframe's faces, and its points. Not thread-safe; keeps its
/// buffers.
class ViewCheck {
 public:
  explicit ViewCheck(const ContradictionOptions& options) : options_(options) {}

  /// Starts over with the points of a view. Points that are not finite are ignored.
  void Begin(const MeshView& view);

  /// A face that the view accepted.
  void Draw(const ProjectedFace& face);

  /// `corners`: the face's own vertices, which say nothing against it.
  FaceSighting Judge(const ProjectedFace& face, const std::array<LandmarkId, 3>& corners) const;

 private:
  struct SeenPoint {
    LandmarkId id;
    Vector2d xy;
    double inverse_depth;
    double margin;  ///< of the inverse depth
  };

  int CellOf(const Vector2d& xy) const;
  int CountSightingsThrough(const ProjectedFace& face,
                            const std::array<LandmarkId, 3>& corners) const;
  template <class Visit>
  void VisitCells(const ProjectedFace& face, const Visit& visit) const;

  ContradictionOptions options_;
  double cell_ = 1;  // side, on the plane z = 1
  Vector2d corner_ = Vector2d::Zero();
  int columns_ = 0, rows_ = 0;
  std::vector<float> inverse_depth_;  // of the faces, by cell; 0: none
  std::vector<SeenPoint> points_;     // by row of cells
  std::vector<int> first_in_row_;     // into points_
};

}  // namespace facet
