// SPDX-License-Identifier: BSD-2-Clause
#include "facet/plausibility/specific_force_check.h"

#include <cstdio>

namespace facet {
namespace {

constexpr double kStretch_s = 2;
// No flight keeps to less than half of gravity or to more than twice that long; what is near
// nothing is a sensor that measures nothing, and no unit.
constexpr double kLeast = 0.5 * kGravity, kMost = 2 * kGravity, kNothing = 0.1;
constexpr double kLeastInG = 0.5, kMostInG = 2;

}  // namespace

std::string SpecificForceCheck::Add(std::span<const ImuSample> samples) {
  if (is_convinced_) return {};
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const double dt_s = ToSeconds(samples[i].t - samples[i - 1].t);
    duration_s_ += dt_s;
    integral_ += dt_s * samples[i].accel.norm();
  }
  if (duration_s_ < kStretch_s) return {};
  const double mean = integral_ / duration_s_;
  duration_s_ = integral_ = 0;
  is_convinced_ = mean > kLeast && mean < kMost;
  if (is_convinced_ || mean < kNothing) return {};
  char text[160];
  std::snprintf(text,
                sizeof(text),
                "for 2 s the accelerometer measured %.3g on average where gravity alone is 9.8 "
                "m/s^2%s",
                mean,
                mean > kLeastInG && mean < kMostInG ? ": it seems to be in g" : "");
  return text;
}

}  // namespace facet
