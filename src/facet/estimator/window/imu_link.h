// SPDX-License-Identifier: BSD-2-Clause
// The IMU between two neighbouring frames, ready for the solver.
#pragma once

#include <string>
#include <vector>

#include "facet/estimator/estimator_options.h"
#include "facet/imu/preintegration.h"

namespace facet {

/// Densities of the random walks of the biases.
struct BiasWalk {
  double gyro;   ///< rad/s^2/sqrt(Hz)
  double accel;  ///< m/s^3/sqrt(Hz)

  BiasWalk(const ImuNoise& noise, const ImuOptions& options);
};

/// What intervals are integrated with: the densities of the calibration, as far as they are not
/// inflated already (ImuOptions::max_gyro_noise), times the factors of the options, and gravity.
ImuParameters ParametersInUse(const ImuNoise& noise, const ImuOptions& options);

/// What is to be said of densities that ParametersInUse takes for inflated; empty: nothing.
std::vector<std::string> InflationWarnings(const ImuNoise& noise, const ImuOptions& options);

/// What ties a frame to the one before it, while both have velocity and biases.
struct ImuLink {
  ImuPreintegration measured;
  Matrix<15, 15> sqrt_info = Matrix<15, 15>::Zero();  ///< see ImuSqrtInfo
  /// There were no samples: constant velocity stands in for them, with very wide noise.
  bool is_synthetic = false;
};

/// Angular rate in B at the end of the interval.
Vector3d RateAtEnd(const ImuLink& link, const ImuBias& bias);

/// Inverse Cholesky factor of the covariance of `measured` and of the walk of the biases (theta p v
/// b_g b_a): whitened residual = ImuSqrtInfo * residual (docs/math.md, section 2.4).
Matrix<15, 15> ImuSqrtInfo(const ImuPreintegration& measured, const BiasWalk& walk);

}  // namespace facet
