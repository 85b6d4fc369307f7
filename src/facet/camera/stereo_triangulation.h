// SPDX-License-Identifier: BSD-2-Clause
// The depth of a point of which a stereo pair has both pixels.
#pragma once

#include <optional>

#include "facet/geometry/se3.h"

namespace facet {

struct StereoDepth {
  double inverse_depth = 0;  ///< [1/m] along z of the left camera; may be negative
  /// From the projection at this depth to the right point, on its plane z = 1.
  double off_line = 0;
};

/// The depth on the ray of the left point whose projection is nearest to the right one. Both are
/// given on the plane z = 1. Empty where the right point says nothing about depth, or the point
/// would be behind the right camera.
inline std::optional<StereoDepth> TriangulateOnRay(const Vector2d& xy_left,
                                                   const Vector2d& xy_right,
                                                   const SE3& T_C1C0) {
  // p_C1 ~ a + rho b must be parallel to (x, y, 1).
  const Vector3d a = T_C1C0.q * Vector3d(xy_left.x(), xy_left.y(), 1);
  const Vector3d& b = T_C1C0.p;
  const Vector2d at_infinity = a.head<2>() - a.z() * xy_right;
  const Vector2d direction = b.head<2>() - b.z() * xy_right;
  const double length2 = direction.squaredNorm();
  if (length2 < 1e-12) return std::nullopt;
  const double rho = -at_infinity.dot(direction) / length2;
  const double depth_ratio = a.z() + rho * b.z();
  if (depth_ratio < 1e-3) return std::nullopt;
  return StereoDepth{rho, (at_infinity + rho * direction).norm() / depth_ratio};
}

}  // namespace facet
