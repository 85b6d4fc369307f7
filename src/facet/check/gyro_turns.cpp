// SPDX-License-Identifier: BSD-2-Clause
#include "facet/check/gyro_turns.h"

#include <algorithm>

#include "facet/geometry/so3.h"

namespace facet {
namespace {

constexpr double kHole_s = 0.1;

}  // namespace

/// Between the samples before and at `behind`.
Vector3d GyroTrack::At(std::size_t behind, Timestamp t) const {
  const Sample &a = samples_[behind - 1], &b = samples_[behind];
  const double share = ToSeconds(t - a.t) / std::max(ToSeconds(b.t - a.t), 1e-9);
  return a.gyro + share * (b.gyro - a.gyro);
}

bool GyroTrack::Turn(Timestamp begin, Timestamp end, Vector3d& theta) const {
  const auto first = std::ranges::upper_bound(samples_, begin, {}, &Sample::t);
  if (first == samples_.begin() || first == samples_.end() || samples_.back().t < end) return false;
  auto i = static_cast<std::size_t>(first - samples_.begin());
  Quaterniond R = Quaterniond::Identity();
  Timestamp t = begin;
  Vector3d gyro = At(i, begin);
  for (; t < end; ++i) {
    if (ToSeconds(samples_[i].t - samples_[i - 1].t) > kHole_s) return false;
    const Timestamp next = std::min(samples_[i].t, end);
    const Vector3d gyro_next = At(i, next);
    R = R * ExpSO3(0.5 * ToSeconds(next - t) * (gyro + gyro_next));
    t = next;
    gyro = gyro_next;
  }
  theta = LogSO3(R.normalized());
  return true;
}

}  // namespace facet
