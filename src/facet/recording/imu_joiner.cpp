// SPDX-License-Identifier: BSD-2-Clause
#include "facet/recording/imu_joiner.h"

namespace facet {
namespace {

constexpr Duration kLongestGap{100000000};
constexpr std::size_t kMaxWaiting = 10000;  // rates; of an accelerometer that has stopped

}  // namespace

void ImuJoiner::LeaveOut(Timestamp t, Timestamp newest) {
  ++(t == newest ? left_out_.num_repeated : left_out_.num_backward);
}

void ImuJoiner::AddSample(const ImuSample& sample) {
  if (!sample.gyro.allFinite() || !sample.accel.allFinite()) {
    ++num_not_finite_;
  } else if (last_ && sample.t <= *last_) {
    LeaveOut(sample.t, *last_);
  } else {
    last_ = sample.t;
    samples_.push_back(sample);
  }
}

void ImuJoiner::AddGyro(Timestamp t, const Vector3d& gyro) {
  if (!gyros_.empty() && t <= gyros_.back().t) {
    LeaveOut(t, gyros_.back().t);
    return;
  }
  gyros_.push_back({t, gyro});
  if (gyros_.size() <= kMaxWaiting) return;
  gyros_.pop_front();
  ++num_without_accel_;
}

void ImuJoiner::AddAccel(Timestamp t, const Vector3d& accel) {
  if (!accel.allFinite()) {
    ++num_not_finite_;
    return;
  }
  if (last_accel_ && t <= last_accel_->t) {
    LeaveOut(t, last_accel_->t);
    return;
  }
  for (; !gyros_.empty() && gyros_.front().t <= t; gyros_.pop_front()) {
    const Reading& gyro = gyros_.front();
    if (!last_accel_ || gyro.t < last_accel_->t || t - last_accel_->t > kLongestGap) {
      ++num_without_accel_;
      continue;
    }
    const double share = ToSeconds(gyro.t - last_accel_->t) / ToSeconds(t - last_accel_->t);
    ImuSample sample;
    sample.t = gyro.t;
    sample.gyro = gyro.value;
    sample.accel = last_accel_->value + share * (accel - last_accel_->value);
    AddSample(sample);
  }
  last_accel_ = {t, accel};
}

void ImuJoiner::Clear() {
  *this = ImuJoiner();
}

std::vector<std::string> ImuJoiner::Warnings() const {
  std::vector<std::string> warnings;
  const auto warn = [&](int num, const char* text) {
    if (num > 0) warnings.push_back(std::to_string(num) + text);
  };
  warn(num_not_finite_, " IMU messages are not finite and were left out");
  warn(left_out_.num_repeated + left_out_.num_backward,
       " IMU messages repeat a stamp or come too late and were left out");
  warn(num_without_accel_, " angular rates have no acceleration around them and were left out");
  return warnings;
}

}  // namespace facet
