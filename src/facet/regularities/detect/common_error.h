// SPDX-License-Identifier: BSD-2-Clause
// What the points of a view have in common beside their own noise: errors of the lenses and of the
// stereo pair that are left when the calibration has been estimated.
#pragma once

#include <cmath>

#include "facet/geometry/plane.h"
#include "facet/regularities/detect/surface_face.h"

namespace facet {

/// 1-sigma of how far a plane is off where all its points are.
struct CommonError {
  double offset_m = 0;   ///< across it
  double slope_rad = 0;  ///< about each axis in it
};

/// Of a plane around the point p_W on it. With pi = n / d in the camera's frame, the points of a
/// plane have the inverse depths 1/z = pi . (x, y, 1). Disparities that are off by (e_x, e_y, e_0)
/// . (x, y, 1), each kCommonDisparity_px, change pi by a focal_px * baseline_m-th of that: so the
/// plane turns by d times that change, and moves by d |p| times it at p. The two go together where
/// a plane is seen at a flat angle (it turns about the point nearest to the camera), which their
/// users neglect.
inline CommonError CommonErrorOf(const Plane& plane_W,
                                 const Vector3d& p_W,
                                 const FaceCamera& camera) {
  const double slope = std::abs(plane_W.SignedDistance(camera.p_W)) * camera.sigma_inverse_depth;
  return {slope * (p_W - camera.p_W).norm(), slope};
}

}  // namespace facet
