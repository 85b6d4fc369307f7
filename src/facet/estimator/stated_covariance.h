// SPDX-License-Identifier: BSD-2-Clause
// By what the covariance of the solve is multiplied before it is stated. The solve takes noise as
// it is for an IMU that shakes on a drone, and the calibration for a careful one; what it leaves
// over says whether they are (docs/math.md, section 4.7).
#pragma once

#include "facet/base/types.h"

namespace facet {

/// Not thread-safe.
class StatedCovariance {
 public:
  /// `accel_noise_scale`: the noise that the solve assumes, over that of the IMU's calibration; no
  /// IMU is quieter than that.
  explicit StatedCovariance(double accel_noise_scale);

  /// After a keyframe's solve: ImuPositionError of the interval that ends with it.
  void AddImuError(double mean_square);

  /// See SelfCalibration::Surprise.
  void SetCalibrationSurprise(double ratio) { calibration_surprise_ = ratio; }

  /// The calibration was given room, so that it is no surprise any more; where it has led to stays.
  /// `newest`: the covariance of the solve.
  void CalibrationIsFreed(const Matrix<15, 15>& newest);

  /// `covariance`: of the solve, of theta p v b_g b_a.
  Matrix<15, 15> Of(const Matrix<15, 15>& covariance) const;

 private:
  double OfImu() const;
  double OfCalibration() const;

  double least_of_imu_;
  double imu_sum_ = 0, imu_weight_ = 0;
  double calibration_surprise_ = 0;
  Matrix3d astray_ = Matrix3d::Zero();  // of positions
};

}  // namespace facet
