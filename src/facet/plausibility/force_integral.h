// SPDX-License-Identifier: BSD-2-Clause
// What an accelerometer has measured over an interval, each of its axes for itself.
#pragma once

#include <span>

#include "facet/geometry/so3.h"
#include "facet/imu/imu_types.h"

namespace facet {

/// In the body frame of the interval's beginning; gravity is in it, and there are no covariances.
/// Not thread-safe.
class ForceIntegral {
 public:
  /// `gyro_scale`: by what share the gyroscope reads too much, by axis (StereoRig).
  explicit ForceIntegral(const Vector3d& gyro_bias, const Vector3d& gyro_scale = Vector3d::Zero())
      : b_g_(gyro_bias), gyro_scale_(gyro_scale) {}

  /// `samples`: in order of time, from the last one of the call before to the end of the interval.
  void Integrate(std::span<const ImuSample> samples);

  double dt_s() const { return dt_s_; }

  /// Column k: the velocity [m/s] and the displacement [m] by axis k of the accelerometer alone.
  struct ByAxis {
    Matrix3d velocity = Matrix3d::Zero(), displacement = Matrix3d::Zero();
  };
  const ByAxis& measured() const { return measured_; }
  /// The same as if each axis had always measured 1 m/s^2.
  const ByAxis& constant() const { return constant_; }

 private:
  void Step(const ImuSample& a, const ImuSample& b);

  Vector3d b_g_, gyro_scale_;
  double dt_s_ = 0;
  Matrix3d R_ = Matrix3d::Identity();  // from the body at the end so far to that of the beginning
  ByAxis measured_, constant_;
};

}  // namespace facet
