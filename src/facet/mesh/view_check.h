// SPDX-License-Identifier: BSD-2-Clause
// Does a face of the horizon mesh agree with what the newest keyframe sees? (What the paper leaves
// open in II-A.2: occlusion, overlapping and contradictory faces.)
#pragma once

#include <array>
#include <vector>

#include "facet/mesh/mesh_view.h"

namespace facet {

/// A point as a view sees it. Views that reach farther from the axis than the plane z = 1 does are
/// projected stereographically.
struct ProjectedPoint {
  Vector2d xy = Vector2d::Zero();
  /// Linear over a face; 0: not in view. Of views that are projected stereographically the inverse
  /// distance, which is off by 3 % in the middle of a face of 28 deg.
  double inverse_depth = 0;
};

using ProjectedFace = std::array<ProjectedPoint, 3>;

/// What the view says about a face of earlier views.
struct FaceVisibility {
  bool is_covered = false;   ///< newer faces lie on it
  int num_seen_through = 0;  ///< points and surface that the view sees behind it
};

/// A coarse depth image of the newest keyframe's faces, and its points. Not thread-safe; keeps its
/// buffers.
class ViewCheck {
 public:
  /// Starts over with the points of a view. Points that are not finite are ignored.
  void Begin(const MeshView& view);

  /// Of the view that has begun, in the left camera [m].
  ProjectedPoint Project(const Vector3d& p_C) const;

  /// A face that the view accepted. Ignored when a corner is not in view.
  void Draw(const ProjectedFace& face);

  /// `corners`: the face's own vertices, which say nothing against it. Nothing is said about a face
  /// with a corner that is not in view.
  FaceVisibility Judge(const ProjectedFace& face, const std::array<LandmarkId, 3>& corners) const;

 private:
  struct SeenPoint {
    LandmarkId id;
    Vector2d xy;
    double inverse_depth;
    double margin;  ///< of the inverse depth
    int bin;
  };

  bool IsBeside(const ProjectedFace& face) const;
  int BinOf(const Vector2d& xy) const;
  int CountPointsBehind(const ProjectedFace& face, const std::array<LandmarkId, 3>& corners) const;
  template <class Visit>
  void VisitRows(const ProjectedFace& face, const Visit& visit) const;

  bool is_wide_ = false;
  double cell_ = 1;  // side, as projected
  Vector2d corner_ = Vector2d::Zero();
  int columns_ = 0, rows_ = 0;
  std::vector<float> inverse_depth_;  // of the faces, by cell; 0: none
  // The points in bins of some cells.
  struct {
    int columns = 1, rows = 1;
  } bins_;
  std::vector<SeenPoint> points_;  // by bin
  std::vector<int> first_in_bin_;  // into points_; one more at the end
};

}  // namespace facet
