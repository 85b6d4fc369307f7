// SPDX-License-Identifier: BSD-2-Clause
// IMU samples in order from messages that may not be.
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "facet/imu/imu_types.h"
#include "facet/io/stamp_counts.h"

namespace facet {

/// Takes samples, or rates and accelerations each with their own stamps: then accelerations are
/// interpolated to the stamps of the rates, but not over more than 0.1 s. Stamps of the samples
/// that come out rise strictly; what is not finite, repeated or late is left out and counted. Not
/// thread-safe.
class ImuJoiner {
 public:
  void AddSample(const ImuSample& sample);
  void AddGyro(Timestamp t, const Vector3d& gyro);    ///< rad/s
  void AddAccel(Timestamp t, const Vector3d& accel);  ///< m/s^2

  std::deque<ImuSample>& samples() { return samples_; }  ///< the caller takes them from the front

  void Clear();  ///< forgets everything, counts too

  std::vector<std::string> Warnings() const;
  const StampCounts& left_out() const { return left_out_; }

 private:
  void LeaveOut(Timestamp t, Timestamp newest);

  struct Reading {
    Timestamp t;
    Vector3d value;
  };

  std::deque<ImuSample> samples_;
  std::deque<Reading> gyros_;  ///< that wait for an acceleration behind them
  std::optional<Reading> last_accel_;
  std::optional<Timestamp> last_;
  int num_not_finite_ = 0, num_without_accel_ = 0;
  StampCounts left_out_;
};

}  // namespace facet
