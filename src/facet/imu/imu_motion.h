// SPDX-License-Identifier: BSD-2-Clause
// Where the IMU says that the body has gone, without how certain that is.
#pragma once

#include <span>

#include "facet/imu/midpoint_step.h"

namespace facet {

/// The motion between two stamps, in the body frame at the first of them and without gravity: dR =
/// R_i^T R_j, dv = R_i^T (v_j - v_i - g T), dp = R_i^T (p_j - p_i - v_i T - g T^2 / 2).
struct ImuMotion {
  double dt_s = 0;
  Quaterniond dR = Quaterniond::Identity();
  Vector3d dp = Vector3d::Zero();
  Vector3d dv = Vector3d::Zero();

  /// Extends it by a step that begins at dR.
  void Add(double step_s, const MidpointStep& step);

  /// The state after the motion, but for the stamp, which stays. `correction`: of (theta, p, v),
  /// theta on the right of dR.
  NavState From(const NavState& start,
                const Vector3d& g_W,
                const Vector<9>& correction = Vector<9>::Zero()) const;
};

/// Midpoint rule, about a bias; the gyroscope counts without a scale. CHECKs that the samples are
/// in order of time.
ImuMotion IntegrateMotion(std::span<const ImuSample> samples, const ImuBias& bias);

}  // namespace facet
