// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/window/image_motion.h"

#include <algorithm>
#include <cmath>

namespace facet {

namespace {

constexpr double kConstantRates_s = 0.002;
// Of the samples that say how the rates change: as long as the offset, but some for certain, and no
// more than motion is a straight line.
constexpr double kShortest_s = 0.02, kLongest_s = 0.05;

// A straight line through the last samples.
struct Trend {
  Vector3d gyro, gyro_slope, accel, accel_slope;  // at the last sample, per second
};

Trend TrendAtEnd(const std::vector<ImuSample>& samples, double length_s) {
  Vector3d gyro = Vector3d::Zero(), accel = Vector3d::Zero();
  Vector3d gyro_moment = Vector3d::Zero(), accel_moment = Vector3d::Zero();
  double n = 0, sum_t = 0, sum_tt = 0;
  const Timestamp end = samples.back().t;
  for (auto s = samples.rbegin(); s != samples.rend(); ++s) {
    const double t = ToSeconds(s->t - end);
    if (t < -length_s - 1e-6) break;
    n += 1;
    sum_t += t;
    sum_tt += t * t;
    gyro += s->gyro;
    accel += s->accel;
    gyro_moment += t * s->gyro;
    accel_moment += t * s->accel;
  }
  const double determinant = n * sum_tt - sum_t * sum_t;
  if (n < 3 || determinant < 1e-12) {
    return {samples.back().gyro, Vector3d::Zero(), samples.back().accel, Vector3d::Zero()};
  }
  const auto value = [&](const Vector3d& sum, const Vector3d& moment) -> Vector3d {
    return (sum_tt * sum - sum_t * moment) / determinant;
  };
  const auto slope = [&](const Vector3d& sum, const Vector3d& moment) -> Vector3d {
    return (n * moment - sum_t * sum) / determinant;
  };
  return {value(gyro, gyro_moment),
          slope(gyro, gyro_moment),
          value(accel, accel_moment),
          slope(accel, accel_moment)};
}

}  // namespace

ImageMotion MotionToImage(const ImuLink& link, const NavState& x, double offset_s) {
  ImageMotion motion;
  motion.w_B = RateAtEnd(link, x.bias);
  const std::vector<ImuSample>& samples = link.measured.samples();
  if (samples.empty() || link.is_synthetic || std::abs(offset_s) <= kConstantRates_s) return motion;
  const double reach = std::clamp(offset_s, -kLongest_s, kLongest_s);
  const Trend trend = TrendAtEnd(samples, std::max(std::abs(reach), kShortest_s));
  // Means over the way; the second integral of the acceleration weighs its beginning twice.
  motion.w_B = trend.gyro + 0.5 * reach * trend.gyro_slope - x.bias.b_g;
  const Vector3d f_B = trend.accel + reach / 3 * trend.accel_slope - x.bias.b_a;
  motion.dv_B = 0.5 * reach * (f_B + x.T_WB.q.conjugate() * link.measured.g_W());
  return motion;
}

}  // namespace facet
