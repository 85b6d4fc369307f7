// SPDX-License-Identifier: BSD-2-Clause
// What the IMU measures and the state that it drives.
#pragma once

#include "facet/base/options.h"
#include "facet/geometry/se3.h"

namespace facet {

/// Gravity in the world frame is (0, 0, -kGravity).
inline constexpr double kGravity = 9.81;
inline Vector3d GravityInWorld() {
  return {0, 0, -kGravity};
}

struct ImuSample {
  Timestamp t;
  Vector3d gyro;   ///< w_B [rad/s]
  Vector3d accel;  ///< specific force a_B [m/s^2]
  /// Standard deviations of what the sample may be off by beyond its noise, per axis; not zero at
  /// the end of the sensor's range. See ImuScreen.
  Vector3d gyro_doubt = Vector3d::Zero();
  Vector3d accel_doubt = Vector3d::Zero();
};

struct ImuBias {
  Vector3d b_g = Vector3d::Zero();  ///< [rad/s]
  Vector3d b_a = Vector3d::Zero();  ///< [m/s^2]
};

/// Continuous-time noise densities as on a datasheet (EuRoC's sensor.yaml, Kalibr's imu.yaml).
struct ImuNoise {
  double gyro_noise = 1.6968e-4;  ///< rad/s/sqrt(Hz)
  double gyro_walk = 1.9393e-5;   ///< rad/s^2/sqrt(Hz)
  double accel_noise = 2.0e-3;    ///< m/s^2/sqrt(Hz)
  double accel_walk = 3.0e-3;     ///< m/s^3/sqrt(Hz)
  double rate_hz = 200;
};

/// T_WB, velocity and biases of the body at one stamp. Tangent order: theta p v b_g b_a (15).
struct NavState {
  Timestamp t;
  SE3 T_WB;
  Vector3d v_WB = Vector3d::Zero();  ///< m/s, in W
  ImuBias bias;
};

}  // namespace facet
