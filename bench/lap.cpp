// SPDX-License-Identifier: BSD-2-Clause
#include "lap.h"

#include <algorithm>
#include <cmath>

#include "facet/geometry/so3.h"
#include "facet/io/errors.h"

namespace facet {

namespace {

// Between the end of a lap and its beginning, beyond the motion from one frame to the next.
constexpr double kMaxJump_m = 0.02;
constexpr double kMaxJump_rad = 0.05;

const NavState& StateAt(std::span<const NavState> truth, Timestamp t) {
  const auto after =
      std::lower_bound(truth.begin(), truth.end(), t, [](const NavState& s, Timestamp stamp) {
        return s.t < stamp;
      });
  return after == truth.end() ? truth.back() : *after;
}

Vector3d Turn(const NavState& from, const NavState& to) {
  return LogSO3(from.T_WB.q.conjugate() * to.T_WB.q);
}

/// The last two frames of a lap and the first one.
void RequireClosed(const NavState& second_last, const NavState& last, const NavState& first) {
  const double step_s = ToSeconds(last.t - second_last.t);
  const Vector3d v_W = 0.5 * (first.v_WB + last.v_WB);
  const double jump_m = (first.T_WB.p - last.T_WB.p - v_W * step_s).norm();
  const double jump_rad = (Turn(last, first) - Turn(second_last, last)).norm();
  if (jump_m < kMaxJump_m && jump_rad < kMaxJump_rad) return;
  throw InputError("the lap is not closed: its end is " + std::to_string(jump_m) + " m and " +
                   std::to_string(jump_rad) + " rad from its beginning");
}

}  // namespace

Lap::Lap(std::span<const Timestamp> frames,
         std::span<const ImuSample> imu,
         std::span<const NavState> truth,
         const std::optional<ImuBias>& bias)
    : frames_(frames.begin(), frames.end()) {
  if (frames.size() < 3 || imu.empty() || truth.empty())
    throw InputError("a lap needs three frames, IMU samples and ground truth");
  const Duration step = frames[1] - frames[0];
  period_ = frames.back() - frames.front() + step;
  const NavState& first = StateAt(truth, frames.front());
  RequireClosed(StateAt(truth, frames[frames.size() - 2]), StateAt(truth, frames.back()), first);
  if (!first.bias.b_g.allFinite() || !first.bias.b_a.allFinite())
    throw InputError("a lap needs the biases of the IMU in its ground truth");
  bias_ = bias.value_or(first.bias);
  for (ImuSample sample : imu) {
    if (sample.t < frames.front() || sample.t >= frames.front() + period_) continue;
    const ImuBias& own = StateAt(truth, sample.t).bias;
    sample.gyro += bias_.b_g - own.b_g;
    sample.accel += bias_.b_a - own.b_a;
    imu_.push_back(sample);
  }
}

Timestamp Lap::FrameStamp(int lap, int frame) const {
  return frames_[static_cast<std::size_t>(frame)] + Duration{lap * period_.ns};
}

std::vector<ImuSample> Lap::ImuOf(int lap) const {
  std::vector<ImuSample> samples = imu_;
  for (ImuSample& sample : samples)
    sample.t = sample.t + Duration{lap * period_.ns};
  return samples;
}

}  // namespace facet
