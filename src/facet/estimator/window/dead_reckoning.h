// SPDX-License-Identifier: BSD-2-Clause
// The motion of the body by its IMU alone, with what is known of it.
#pragma once

#include "facet/estimator/window/imu_link.h"

namespace facet {

struct ReckonedState {
  NavState x;
  Matrix<15, 15> covariance = Matrix<15, 15>::Zero();  ///< theta p v b_g b_a, as NavState's tangent
};

/// The state at the end of the interval, whose IMU is `measured`: Predict of docs/math.md, section
/// 2, and its linearisation for the covariance.
ReckonedState Reckon(const ReckonedState& from,
                     const ImuPreintegration& measured,
                     const BiasWalk& walk);

}  // namespace facet
