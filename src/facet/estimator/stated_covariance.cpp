// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/stated_covariance.h"

#include <algorithm>
#include <cmath>

namespace facet {
namespace {

// What recordings of a flying and of a hand-held rig leave over, for which the assumed noise is
// right (0.10 and 0.12 on EuRoC; 0.014 to 0.037 with the noise of the IMU's calibration alone).
constexpr double kOfShakingImu = 0.12;
// What is believed before anything is measured counts as so many keyframes, and what was measured
// no more than so many.
constexpr double kNumBelieved = 25, kMaxWeight = 500;
// One contradiction is no noise.
constexpr double kLargestError = 1;
// Errors that do not look like noise are left: of patches, of lenses.
constexpr double kLeastFactor = 0.2;
// A calibration may be hopeless, but then positions are, too.
constexpr double kMaxSurprise = 25;

}  // namespace

StatedCovariance::StatedCovariance(double accel_noise_scale)
    : least_of_imu_(std::clamp(1 / (accel_noise_scale * accel_noise_scale), kLeastFactor, 1.0)) {}

void StatedCovariance::AddImuError(double mean_square) {
  if (!std::isfinite(mean_square)) return;
  const double forgotten = std::min(1.0, kMaxWeight / (imu_weight_ + 1));
  imu_sum_ = forgotten * (imu_sum_ + std::min(mean_square, kLargestError));
  imu_weight_ = forgotten * (imu_weight_ + 1);
}

// Less where the IMU is quieter than was assumed.
double StatedCovariance::OfImu() const {
  const double ratio = (imu_sum_ / kOfShakingImu + kNumBelieved) / (imu_weight_ + kNumBelieved);
  return std::clamp(ratio, least_of_imu_, 1.0);
}

// More where the calibration has turned out to be worse.
double StatedCovariance::OfCalibration() const {
  const double surprise =
      std::isfinite(calibration_surprise_) ? calibration_surprise_ : kMaxSurprise;
  return std::clamp(surprise, 1.0, kMaxSurprise);
}

void StatedCovariance::CalibrationIsFreed(const Matrix<15, 15>& newest) {
  astray_ += OfImu() * (OfCalibration() - 1) * newest.block<3, 3>(3, 3);
}

Matrix<15, 15> StatedCovariance::Of(const Matrix<15, 15>& covariance) const {
  Matrix<15, 15> stated = OfImu() * OfCalibration() * covariance;
  stated.block<3, 3>(3, 3) += astray_;
  return stated;
}

}  // namespace facet
