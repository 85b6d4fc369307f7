// SPDX-License-Identifier: BSD-2-Clause
#include "facet/plausibility/dead_imu_check.h"

#include <algorithm>
#include <cstdio>
#include <vector>

#include "facet/base/median.h"

namespace facet {
namespace {

// At any rate so many samples that the noise of the poorest sensor shows in one of them.
constexpr double kStretch_s = 1.5;
// The ends of intervals are interpolated, and so off by roundings; sensors have coarser digits.
constexpr double kRounding = 1e-9;
// Whatever the body does, for so long the mean is not further from gravity (SpecificForceCheck).
constexpr double kLeastForce = 0.5 * kGravity, kMostForce = 2 * kGravity;
// Median motion of the landmarks since an older frame, and of how many. What a camera at rest sees
// moves by a tenth.
constexpr double kMoved_px = 1;
constexpr std::size_t kLeastShared = 10;

bool IsSame(const Vector3d& a, const Vector3d& b) {
  return (a - b).cwiseAbs().maxCoeff() <= kRounding * std::max(1.0, a.cwiseAbs().maxCoeff());
}

}  // namespace

std::string DeadImuCheck::Add(std::span<const ImuSample> imu,
                              std::span<const FeatureObservation> features) {
  if (is_decided_) return {};
  AddImu(imu);
  if (is_decided_) return {};
  AddImages(features);
  if (!first_ || ToSeconds(newest_->t - first_->t) < kStretch_s) return {};
  const double force = first_->accel.norm();
  if (!images_move_ && force > kLeastForce && force < kMostForce) return {};
  is_decided_ = true;
  return InWords();
}

// An accelerometer that lives decides it.
void DeadImuCheck::AddImu(std::span<const ImuSample> imu) {
  for (const ImuSample& sample : imu) {
    if (!first_) first_ = sample;
    newest_ = sample;
    gyro_lives_ = gyro_lives_ || !IsSame(first_->gyro, sample.gyro);
    is_decided_ = is_decided_ || !IsSame(first_->accel, sample.accel);
  }
}

void DeadImuCheck::AddImages(std::span<const FeatureObservation> features) {
  if (images_move_) return;
  std::vector<double> moved_px;
  for (const FeatureObservation& feature : features) {
    const auto before = reference_px_.find(feature.landmark);
    if (before != reference_px_.end())
      moved_px.push_back((feature.px_left - before->second).norm());
  }
  if (moved_px.size() >= kLeastShared) {
    images_move_ = *Median(moved_px) > kMoved_px;
    return;
  }
  reference_px_.clear();
  for (const FeatureObservation& feature : features)
    reference_px_[feature.landmark] = feature.px_left;
}

std::string DeadImuCheck::InWords() const {
  char text[400];
  const Vector3d &w = first_->gyro, &a = first_->accel;
  std::snprintf(text,
                sizeof(text),
                "%s has sent one value for %.1f s, digit by digit, since its first sample "
                "(gyroscope %.4g %.4g %.4g rad/s, accelerometer %.4g %.4g %.4g m/s^2)%s: is the "
                "sensor connected, and does its driver send new samples (imu0/data.csv)?",
                gyro_lives_ ? "the accelerometer" : "the IMU",
                ToSeconds(newest_->t - first_->t),
                w.x(),
                w.y(),
                w.z(),
                a.x(),
                a.y(),
                a.z(),
                images_move_ ? " while the images move" : "");
  return text;
}

}  // namespace facet
