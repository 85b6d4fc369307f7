// SPDX-License-Identifier: BSD-2-Clause
// What the covariance of the solve becomes before it is stated. The solve takes noise for that of
// an IMU that shakes on a drone, and the calibration for a careful one; what it leaves over says
// whether they are (docs/math.md, section 4.7).
#pragma once

#include "facet/base/types.h"

namespace facet {

/// Not thread-safe.
class StatedCovariance {
 public:
  /// `accel_noise_scale`: the noise that the solve assumes, over that of the IMU's calibration; no
  /// IMU is quieter than that. `axes_sigma`: of the directions of the body's axes [rad].
  explicit StatedCovariance(double accel_noise_scale, double axes_sigma = 0);

  /// After a keyframe's solve: ImuPositionError of the interval that ends with it. Not where
  /// something else than noise decides: without landmarks, after a contradiction.
  void AddImuError(double mean_square);

  /// See SelfCalibration::Surprise.
  void SetCalibrationSurprise(double ratio);

  /// After a keyframe's solve and these two: its covariance.
  void AddKeyframe(const Matrix<15, 15>& solved);

  /// The state was given up: the next covariance begins with nothing again.
  void StartOver();

  /// `solved`: of the solve, of theta p v b_g b_a.
  Matrix<15, 15> Of(const Matrix<15, 15>& solved) const;

  /// For what was learnt of the calibration: by images and IMU together, as of late.
  double OfLearnt() const { return OfImu() * of_calibration_; }

  /// Of the variances that were taken over from before the last StartOver: never less than 1.
  double OfOrigin() const { return of_origin_; }

 private:
  struct Mean {
    double max_weight;  // in keyframes
    double weight = 0, value = 1;

    void Add(double measured);
  };

  double Measured() const;
  double Believed(double measured) const;
  double OfImu() const { return Believed(Measured()); }
  double OfWay() const { return Believed(of_way_measured_) * of_way_calibration_; }

  double least_of_imu_, axes_variance_;
  Mean imu_lately_{50}, imu_for_long_{500};
  double of_calibration_ = 1;
  /// Position and heading are sums of the whole way; each part of it counts as it was when it was
  /// added.
  double of_way_measured_ = 1, of_way_calibration_ = 1;
  double largest_position_variance_ = 0;
  double of_origin_ = 1;
};

}  // namespace facet
