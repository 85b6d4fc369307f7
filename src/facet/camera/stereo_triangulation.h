// SPDX-License-Identifier: BSD-2-Clause
// The depth of a point of which a stereo pair has both pixels.
#pragma once

#include <optional>

#include <Eigen/LU>

#include "facet/camera/camera_model.h"
#include "facet/geometry/se3.h"

namespace facet {

struct StereoDepth {
  double inverse_depth = 0;  ///< [1/m] along z of the left camera; may be negative
  /// From the projection at this depth to the right point, to first order [pixels of the right
  /// image].
  double off_line_px = 0;
  /// How far the right pixel moves when the inverse depth grows, to first order [px m].
  double px_per_inverse_depth = 0;
};

/// The depth on the ray of the left point (on its plane z = 1) whose projection is nearest to the
/// right one on that camera's plane z = 1. Empty where the right point says nothing about depth, or
/// the point would be behind the right camera.
inline std::optional<StereoDepth> TriangulateOnRay(const Vector2d& xy_left,
                                                   const UndistortedPoint& right,
                                                   const SE3& T_C1C0) {
  // p_C1 ~ a + rho b must be parallel to (x, y, 1).
  const Vector3d a = T_C1C0.q * Vector3d(xy_left.x(), xy_left.y(), 1);
  const Vector3d& b = T_C1C0.p;
  const Vector2d at_infinity = a.head<2>() - a.z() * right.xy;
  const Vector2d direction = b.head<2>() - b.z() * right.xy;
  const double length2 = direction.squaredNorm();
  if (length2 < 1e-12) return std::nullopt;
  const double rho = -at_infinity.dot(direction) / length2;
  const double depth_ratio = a.z() + rho * b.z();
  if (depth_ratio < 1e-3) return std::nullopt;
  const Matrix2d J_px_xy = right.J_xy_px.inverse();
  return StereoDepth{rho,
                     (J_px_xy * (at_infinity + rho * direction)).norm() / depth_ratio,
                     (J_px_xy * direction).norm() / depth_ratio};
}

}  // namespace facet
