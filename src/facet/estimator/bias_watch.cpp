// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/bias_watch.h"

#include <cmath>
#include <cstdio>

namespace facet {
namespace {

// A failing sensor is noticed over the short span, a creeping one over the long span.
constexpr Duration kShort{3'000'000'000}, kLong{10'000'000'000};
// Good sensors reach 3.1, recorded ones among them (docs/notebook/faults.md).
constexpr double kMaxSigmas = 5;

}  // namespace

std::optional<BiasDrift> BiasWatch::Add(const BiasEvidence& evidence) {
  if (!history_.empty() && evidence.t <= history_.back().t) Break();
  std::optional<BiasDrift> worst;
  const auto compare_with = [&](const BiasEvidence& before) {
    const auto drift = Compare(before, evidence);
    if (drift && (!worst || drift->num_sigmas > worst->num_sigmas)) worst = drift;
  };
  // The newest that is old enough, and the one at the end of the long span.
  for (auto before = history_.rbegin(); before != history_.rend(); ++before) {
    if (evidence.t - before->t < kShort) continue;
    compare_with(*before);
    break;
  }
  while (!history_.empty() && evidence.t - history_.front().t > kLong) {
    compare_with(history_.front());
    history_.pop_front();
  }
  history_.push_back(evidence);
  return worst;
}

// As if both estimates were independent, which they hardly are: the limit is modest.
std::optional<BiasDrift> BiasWatch::Compare(const BiasEvidence& before,
                                            const BiasEvidence& now) const {
  const double seconds = ToSeconds(now.t - before.t);
  std::optional<BiasDrift> worst;
  const auto look = [&](bool is_gyro,
                        const Vector3d& change,
                        const Vector3d& sigma_before,
                        const Vector3d& sigma_now,
                        double walk) {
    for (int axis = 0; axis < 3; ++axis) {
      const double sigma = std::sqrt(sigma_before(axis) * sigma_before(axis) +
                                     sigma_now(axis) * sigma_now(axis) + walk * walk * seconds);
      const double num_sigmas = std::abs(change(axis)) / sigma;
      if (num_sigmas > kMaxSigmas && (!worst || num_sigmas > worst->num_sigmas))
        worst = BiasDrift{is_gyro, axis, change(axis), seconds, num_sigmas};
    }
  };
  look(true, now.bias.b_g - before.bias.b_g, before.sigma_b_g, now.sigma_b_g, noise_.gyro_walk);
  look(false, now.bias.b_a - before.bias.b_a, before.sigma_b_a, now.sigma_b_a, noise_.accel_walk);
  return worst;
}

// An accelerometer that is off is what gravity is off by; a gyroscope turns it for about a second,
// after which the images have the last word.
double TiltOf(const BiasDrift& drift, double gravity) {
  constexpr double kWindow_s = 1;
  return std::abs(drift.change) * (drift.is_gyro ? kWindow_s : 1 / gravity);
}

std::string InWords(const BiasDrift& drift) {
  char text[400];
  std::snprintf(
      text,
      sizeof(text),
      "the %s's bias along %c changed by %.2g %s within %.0f s, %.0f times what its noise "
      "and walk explain: is the IMU loose, failing or at the end of its range, or is the "
      "calibration wrong? From there on the sigmas contain how far the world may be tilted",
      drift.is_gyro ? "gyroscope" : "accelerometer",
      "xyz"[drift.axis],
      drift.change,
      drift.is_gyro ? "rad/s" : "m/s^2",
      drift.seconds,
      drift.num_sigmas);
  return text;
}

}  // namespace facet
