// SPDX-License-Identifier: BSD-2-Clause
// The IMU between two full states: preintegrated motion (9 rows) and bias walk (6 rows).
// Equations (2.x) of docs/math.md; Forster et al., TRO 2017, with additive world position.
#pragma once

#include "facet/imu/preintegration.h"

namespace facet {

/// Rows: theta p v b_g b_a. Columns of J_i and J_j: theta p v b_g b_a of the state.
struct ImuResidual {
  Vector<15> r;
  Matrix<15, 15> J_i;
  Matrix<15, 15> J_j;
};

/// Bias walk densities of the link.
struct BiasWalk {
  double gyro = 1.9393e-5;  ///< rad/s^2/sqrt(Hz)
  double accel = 3.0e-3;    ///< m/s^3/sqrt(Hz)
};

/// Unwhitened residual only, predicted minus measured (rotation: Log(measured^-1 predicted)).
Vector<15> ImuError(const ImuPreintegration& measured, const NavState& i, const NavState& j);

/// Unwhitened residual and Jacobians.
ImuResidual LinearizeImu(const ImuPreintegration& measured, const NavState& i, const NavState& j);

/// How far the two states are from the measured motion: RMS of its whitened errors, those of the
/// rotation or those of position and velocity, whichever is larger. Infinite if not a number.
double ImuErrorSigma(const ImuPreintegration& measured,
                     const Matrix<15, 15>& sqrt_info,
                     const NavState& i,
                     const NavState& j);

/// Inverse Cholesky factor of the 15x15 covariance: whitened residual = ImuSqrtInfo * r.
Matrix<15, 15> ImuSqrtInfo(const ImuPreintegration& measured, const BiasWalk& walk);

}  // namespace facet
