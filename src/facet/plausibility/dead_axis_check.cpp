// SPDX-License-Identifier: BSD-2-Clause
#include "facet/plausibility/dead_axis_check.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace facet {
namespace {

constexpr double kLeast_s = 5;
// The ends of intervals are interpolated, and so off by roundings; sensors have coarser digits.
constexpr double kRounding = 1e-9;
// Between the smallest and the largest value of an axis that moves: many digits of the coarsest
// sensor, and far beyond its noise at rest. Hand-held and flying rigs do so within a second.
constexpr double kGyroMoves = 0.1;   // rad/s
constexpr double kAccelMoves = 0.5;  // m/s^2

bool IsSame(double a, double b) {
  return std::abs(a - b) <= kRounding * std::max(1.0, std::abs(a));
}

}  // namespace

bool DeadAxisCheck::Add(const ImuSample& sample) {
  Values x;
  x << sample.gyro, sample.accel;
  const std::size_t num_before = found_.size();
  for (int axis = 0; axis < kNumAxes; ++axis) {
    Stay& stay = stays_[static_cast<std::size_t>(axis)];
    if (!has_begun_ || !IsSame(stay.value, x(axis))) {
      stay = Stay{x(axis), sample.t, x, x};
      continue;
    }
    stay.low = stay.low.cwiseMin(x);
    stay.high = stay.high.cwiseMax(x);
    if (stay.place != kNotFound) {
      found_[stay.place].to = sample.t;
    } else if (ToSeconds(sample.t - stay.since) >= kLeast_s && DoOthersMove(axis, stay)) {
      stay.place = found_.size();
      found_.push_back({axis < 3, axis % 3, stay.value, stay.since, sample.t});
    }
  }
  has_begun_ = true;
  return found_.size() > num_before;
}

// A body that turns about all axes moves gravity through those of its accelerometer, whatever it
// does besides. One that turns about two axes of its own and is not level turns about the third,
// and accelerations in all directions show that it is shaken, too.
bool DeadAxisCheck::DoOthersMove(int axis, const Stay& stay) {
  const Values range = stay.high - stay.low;
  int num_gyro = 0, num_accel = 0;
  for (int k = 0; k < 3; ++k) {
    num_gyro += range(k) >= kGyroMoves ? 1 : 0;
    num_accel += range(3 + k) >= kAccelMoves ? 1 : 0;
  }
  return axis < 3 ? num_gyro == 2 && num_accel == 3 : num_gyro == 3 && num_accel >= 1;
}

std::string InWords(const DeadAxis& dead) {
  char text[300];
  std::snprintf(text,
                sizeof(text),
                "axis %c of the %s has sent %.4g %s, digit by digit, for %.1f s while the body "
                "turned and shook",
                "xyz"[dead.axis],
                dead.is_gyro ? "gyroscope" : "accelerometer",
                dead.value,
                dead.is_gyro ? "rad/s" : "m/s^2",
                ToSeconds(dead.to - dead.from));
  return text;
}

}  // namespace facet
