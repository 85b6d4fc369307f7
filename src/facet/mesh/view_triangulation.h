// SPDX-License-Identifier: BSD-2-Clause
// The triangles between the points of one keyframe (paper II-A.1): triangulated in the image,
// lifted, and judged whether they are surface.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "facet/geometry/delaunay.h"
#include "facet/mesh/face_filter.h"
#include "facet/mesh/mesh_options.h"
#include "facet/mesh/mesh_view.h"
#include "facet/mesh/triangle_stars.h"

namespace facet {

/// Whether a view can be triangulated at all: it has a pose and a focal length.
bool IsUsable(const MeshView& view);

/// Keeps its buffers; not thread-safe.
class ViewTriangulation {
 public:
  explicit ViewTriangulation(const MeshOptions& options);

  struct Triangle {
    std::array<int, 3> points;  ///< into points(), turning from x to y in the image
    CameraFace seen;
    FaceDefect defect = FaceDefect::kNone;

    bool IsAccepted() const { return defect == FaceDefect::kNone; }
  };

  /// Points that are not finite are left out. The view must be usable.
  void Build(const MeshView& view);

  /// The points of the last view that were triangulated, as indices into it, sorted by id.
  std::span<const int> points() const { return points_; }
  std::span<const Triangle> triangles() const { return triangles_; }

  /// Whether an accepted triangle may vote for planes.
  bool MayVote(const Triangle& triangle) const {
    return triangle.IsAccepted() && voting_.Judge(triangle.seen) == FaceDefect::kNone;
  }
  /// Whether no accepted triangle lies beyond the side opposite to a corner.
  bool IsBoundary(const Triangle& triangle, std::size_t corner) const;

  /// Whether a face of an older view still has a shape that is accepted.
  bool HasGoodShape(const std::array<Vector3d, 3>& p_W) const {
    return accepted_.JudgeShape(p_W) == FaceDefect::kNone;
  }

 private:
  void ListPoints(const MeshView& view);
  void JudgeTriangles(const MeshView& view);
  void RescuePlanes(const MeshView& view);
  bool HasPlaneCorner(const MeshView& view, const Triangle& triangle) const;

  bool rescues_planes_;
  FaceFilter accepted_, voting_, rescued_;  // what a face has to be for each
  Delaunay delaunay_;
  std::vector<int> points_;
  std::vector<GridPoint> grid_;  // of points_
  std::vector<Triangle> triangles_;
  TriangleStars stars_;  // of triangles_, by point
};

}  // namespace facet
