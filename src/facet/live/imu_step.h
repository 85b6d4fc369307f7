// SPDX-License-Identifier: BSD-2-Clause
// One step from IMU sample to IMU sample of a state with its covariance.
#pragma once

#include "facet/estimator/window/dead_reckoning.h"

namespace facet {

/// What a step assumes of the IMU.
struct StepModel {
  ImuParameters parameters;
  BiasWalk walk{ImuNoise{}, ImuOptions{}};
  Vector3d gyro_scale = Vector3d::Zero();  ///< by what share it reads too much on each axis
  double max_step_s = 0.021;               ///< a longer step is a hole: the motion in it is a guess
};

/// Angular rate [rad/s] of the body that the sample says, without bias and scale.
Vector3d RateOf(const ImuSample& sample, const ImuBias& bias, const Vector3d& gyro_scale);

/// Moves the state from sample `a` to sample `b`, midpoint rule, as ImuPreintegration does and
/// Reckon afterwards (docs/math.md, section 2), in one go and without storage. The state's stamp
/// becomes `b`'s. CHECKs that b is not before a.
void Advance(const ImuSample& a, const ImuSample& b, const StepModel& model, ReckonedState& state);

}  // namespace facet
