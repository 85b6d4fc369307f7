// SPDX-License-Identifier: BSD-2-Clause
// The newest state as something from which the IMU alone can go on.
#pragma once

#include "facet/imu/imu_types.h"

namespace facet {

/// What images and IMU said up to a frame, at the frame's moment by the IMU's clock. A state that
/// is output is at the moment of the image instead, as far as the estimated time offset knows it;
/// what that leaves uncertain is not part of this covariance.
struct CausalState {
  NavState x;
  Matrix<15, 15> covariance = Matrix<15, 15>::Zero();  ///< theta p v b_g b_a, as NavState's tangent
  /// By what share the gyroscope reads too much on each of its axes.
  Vector3d gyro_scale = Vector3d::Zero();
};

}  // namespace facet
