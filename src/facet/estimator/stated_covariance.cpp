// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/stated_covariance.h"

#include <algorithm>
#include <cmath>

namespace facet {
namespace {

// What recordings of a flying and of a hand-held rig leave over, for which the assumed noise is
// right (0.10 and 0.12 on EuRoC; 0.014 to 0.037 with the noise of the IMU's calibration alone).
constexpr double kOfShakingImu = 0.12;
// Before anything is measured it counts as so many keyframes that it is as assumed.
constexpr double kNumBelieved = 25;
// One contradiction is no noise.
constexpr double kLargestError = 1;
// Errors that do not look like noise are left: of patches, of lenses.
constexpr double kLeastFactor = 0.2;
// A calibration may be hopeless, but then positions are, too.
constexpr double kMaxSurprise = 25;
// The position becomes better known where planes and places are seen again. By so much of its
// variance per keyframe what it was known to before is forgotten.
constexpr double kForgotten = 1.0 / 500;

}  // namespace

StatedCovariance::StatedCovariance(double accel_noise_scale, double axes_sigma)
    : least_of_imu_(std::clamp(1 / (accel_noise_scale * accel_noise_scale), kLeastFactor, 1.0)),
      axes_variance_(axes_sigma * axes_sigma) {}

void StatedCovariance::Mean::Add(double measured) {
  weight = std::min(weight + 1, max_weight);
  value += (measured - value) / weight;
}

void StatedCovariance::AddImuError(double mean_square) {
  if (!std::isfinite(mean_square)) return;
  const double ratio = std::min(mean_square, kLargestError) / kOfShakingImu;
  imu_lately_.Add(ratio);
  imu_for_long_.Add(ratio);
}

void StatedCovariance::SetCalibrationSurprise(double ratio) {
  of_calibration_ = std::isfinite(ratio) ? std::clamp(ratio, 1.0, kMaxSurprise) : kMaxSurprise;
}

// A rig that begins to shake is believed to at once, one that has become quiet is not.
double StatedCovariance::Measured() const {
  return std::max(imu_lately_.value, imu_for_long_.value);
}

double StatedCovariance::Believed(double measured) const {
  const double weight = imu_for_long_.weight;
  const double ratio = (kNumBelieved + weight * measured) / (kNumBelieved + weight);
  return std::clamp(ratio, least_of_imu_, 1.0);
}

void StatedCovariance::AddKeyframe(const Matrix<15, 15>& solved) {
  const double variance = solved.block<3, 3>(3, 3).trace();
  if (!(variance > 0)) return;
  const double before = (1 - kForgotten) * largest_position_variance_;
  const double share = std::max(0.0, 1 - before / variance);  // of it that is new
  of_way_measured_ += share * (Measured() - of_way_measured_);
  of_way_calibration_ += share * (of_calibration_ - of_way_calibration_);
  // A calibration that turns out to be wrong was so all the way; one that has been mended was not
  // right before.
  of_way_calibration_ = std::max(of_way_calibration_, of_calibration_);
  largest_position_variance_ = std::max(before, variance);
}

void StatedCovariance::StartOver() {
  of_origin_ = std::max(of_origin_, OfWay());
  largest_position_variance_ = 0;
}

Matrix<15, 15> StatedCovariance::Of(const Matrix<15, 15>& solved) const {
  Vector<15> scale;
  scale.head<6>().setConstant(std::sqrt(OfWay()));
  scale.segment<3>(6).setConstant(std::sqrt(OfImu() * of_calibration_));
  // A quiet IMU says nothing of its biases.
  scale.tail<6>().setConstant(std::sqrt(of_calibration_));
  Matrix<15, 15> stated = scale.asDiagonal() * solved * scale.asDiagonal();
  stated.diagonal().head<3>().array() += axes_variance_;
  return stated;
}

}  // namespace facet
