// SPDX-License-Identifier: BSD-2-Clause
// A plane as the points of one keyframe show it that are not landmarks: the depths of its support
// points reach the estimator in this form, with the few numbers that say all of a plane.
#pragma once

#include <array>

#include "facet/base/types.h"

namespace facet {

struct PlaneMeasurement {
  FrameId frame;  ///< the keyframe
  PlaneId plane;
  Vector3d centre_B = Vector3d::Zero();  ///< of the points, on the surface that they span
  /// Two orthogonal unit vectors along that surface: the principal directions of the points, in
  /// which the errors of its slopes do not depend on each other.
  std::array<Vector3d, 2> along_B{Vector3d::UnitX(), Vector3d::UnitY()};
  double sigma_m = 0;                     ///< 1-sigma of the distance at the centre
  std::array<double, 2> sigma_rad{0, 0};  ///< 1-sigma of the slope in either direction
};

}  // namespace facet
