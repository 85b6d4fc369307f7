// SPDX-License-Identifier: BSD-2-Clause
// The distance of a point of which a stereo pair has both pixels.
#pragma once

#include <cmath>
#include <optional>

#include "facet/camera/camera_model.h"
#include "facet/geometry/se3.h"

namespace facet {

struct StereoDistance {
  double inverse_distance = 0;  ///< [1/m] from the left camera; may be negative
  /// From the projection at this distance to the right point, to first order [pixels of the right
  /// image].
  double off_line_px = 0;
  /// How far the right pixel moves when the inverse distance grows, to first order [px m].
  double px_per_inverse_distance = 0;
};

/// The distance along the bearing of the left point whose projection is nearest to the right pixel,
/// to first order and with the lens as it is at that pixel. Empty where the right pixel says
/// nothing about distance, or the right camera would have the point beside or behind it.
inline std::optional<StereoDistance> TriangulateOnRay(const Vector3d& bearing_left,
                                                      const PixelBearing& right,
                                                      const SE3& T_C1C0) {
  // p_C1 ~ a + rho b must be parallel to the right bearing.
  constexpr double kMinShift_px_m = 1e-3, kMinCosine = 1e-3;
  const Vector3d a = T_C1C0.q * bearing_left;
  const Vector3d& b = T_C1C0.p;
  const Vector2d at_infinity = right.J_px_bearing * a;
  const Vector2d direction = right.J_px_bearing * b;
  const double length2 = direction.squaredNorm();
  if (length2 < kMinShift_px_m * kMinShift_px_m) return std::nullopt;
  const double rho = -at_infinity.dot(direction) / length2;
  const double scale = right.bearing.dot(a + rho * b);
  if (scale < kMinCosine) return std::nullopt;
  return StereoDistance{
      rho, (at_infinity + rho * direction).norm() / scale, std::sqrt(length2) / scale};
}

}  // namespace facet
