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

template <class Step>
bool GyroTrack::Integrate(Timestamp begin, Timestamp end, const Step& step) const {
  const auto first = std::ranges::upper_bound(samples_, begin, {}, &Sample::t);
  if (first == samples_.begin() || first == samples_.end() || samples_.back().t < end) return false;
  Timestamp t = begin;
  auto i = static_cast<std::size_t>(first - samples_.begin());
  Vector3d gyro = At(i, begin);
  for (; t < end; ++i) {
    if (ToSeconds(samples_[i].t - samples_[i - 1].t) > kHole_s) return false;
    const Timestamp next = std::min(samples_[i].t, end);
    const Vector3d gyro_next = At(i, next);
    step(0.5 * ToSeconds(next - t) * (gyro + gyro_next));
    t = next;
    gyro = gyro_next;
  }
  return true;
}

bool GyroTrack::Turn(Timestamp begin, Timestamp end, Vector3d& theta) const {
  Quaterniond R = Quaterniond::Identity();
  const auto step = [&](const Vector3d& angle) { R = R * ExpSO3(angle); };
  if (!Integrate(begin, end, step)) return false;
  theta = LogSO3(R.normalized());
  return true;
}

bool GyroTrack::Sum(Timestamp begin, Timestamp end, Vector3d& angle) const {
  angle.setZero();
  return Integrate(begin, end, [&](const Vector3d& part) { angle += part; });
}

}  // namespace facet
