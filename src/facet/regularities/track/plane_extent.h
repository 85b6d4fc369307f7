// SPDX-License-Identifier: BSD-2-Clause
// The extent of a plane: which part of the infinite plane is surface that was seen, in cells of 10
// cm.
#pragma once

#include <array>
#include <vector>

#include "facet/geometry/plane.h"
#include "facet/regularities/track/block_grid.h"

namespace facet {

/// The cells are fixed to a point and two directions of the plane as it was at first; later,
/// slightly different estimates of the plane do not move them. Surface that would make the
/// rectangle around it larger than a square kilometre is left out.
class PlaneExtent {
 public:
  PlaneExtent(const Plane& plane_W, const Vector3d& origin_W);

  /// Triangles of more than 10 m, and those without finite corners, are left out.
  void AddTriangle(const std::array<Vector3d, 3>& p_W);

  /// Takes back the cells around the point's projection.
  void Remove(const Vector3d& p_W);

  /// Whether surface was seen within about `radius_m` (whole half metres) of the point's
  /// projection.
  bool IsNear(const Vector3d& p_W, double radius_m) const;

  /// Whether surface was seen at the point's projection, or in a cell beside it.
  bool HasSurface(const Vector3d& p_W) const;

  /// Whether surface of the other, which lies on `plane_W`, is within about `radius_m`.
  bool IsNear(const PlaneExtent& other, const Plane& plane_W, double radius_m) const;

  /// Adds the cells of the other, which lie on `plane_W`.
  void Add(const PlaneExtent& other, const Plane& plane_W);

  double area_m2() const;

  /// Mean of the cells, on the plane.
  Vector3d Centroid(const Plane& plane_W) const;

  /// Convex hull of the cells, on the plane, counter-clockwise seen from where its normal points.
  std::vector<Vector3d> Outline(const Plane& plane_W) const;

 private:
  void AddCell(int x, int y);
  Vector2d ToPlane(const Vector3d& p_W) const;
  Vector3d ToWorld(const Vector2d& xy, const Plane& plane_W) const;

  Vector3d origin_W_;
  Matrix<3, 2> basis_;
  Vector3d n_W_;
  BlockGrid blocks_;  // of 5 x 5 cells, one bit each
  int num_cells_ = 0;
  Vector2d sum_ = Vector2d::Zero();  // of the cells' middles
};

}  // namespace facet
