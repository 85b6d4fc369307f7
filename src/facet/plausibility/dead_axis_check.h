// SPDX-License-Identifier: BSD-2-Clause
// Recognises a single axis of the IMU that measures nothing: it stays at one value, digit by digit,
// while the others show that the body turns and shakes.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "facet/imu/imu_types.h"

namespace facet {

struct DeadAxis {
  bool is_gyro = false;
  int axis = 0;      ///< 0, 1, 2: x, y, z
  double value = 0;  ///< rad/s or m/s^2
  Timestamp from, to;
};

/// Not thread-safe. Left alone are sensors with coarse digits at rest, and simulated ones without
/// noise that are at rest, move in a plane or turn about one axis only: an axis counts as dead only
/// where what the rest of the IMU measures would have changed it.
class DeadAxisCheck {
 public:
  /// In order of time; a sample may come again. True when one more axis is certainly dead.
  bool Add(const ImuSample& sample);

  /// In the order in which they became certain. `to` grows as long as the axis stays where it is.
  const std::vector<DeadAxis>& found() const { return found_; }

 private:
  static constexpr int kNumAxes = 6;  // gyroscope, accelerometer
  using Values = Vector<kNumAxes>;
  static constexpr std::size_t kNotFound = static_cast<std::size_t>(-1);

  /// How long an axis has been at one value, and where all of them have been meanwhile.
  struct Stay {
    double value = 0;
    Timestamp since;
    Values low, high;
    std::size_t place = kNotFound;  // in found_
  };

  static bool DoOthersMove(int axis, const Stay& stay);

  std::array<Stay, kNumAxes> stays_;
  bool has_begun_ = false;
  std::vector<DeadAxis> found_;
};

/// What is wrong, without advice.
std::string InWords(const DeadAxis& dead);

/// What to do about it.
inline constexpr const char* kDeadAxisAdvice =
    "look at the driver, which may fill in what it does not read, and at the sensor";

}  // namespace facet
