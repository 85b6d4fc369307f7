// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/window/imu_intervals.h"

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

namespace facet {

namespace {

// IMU noise over an interval with a hole, and over one without any sample, times the usual.
constexpr double kGapNoiseScale = 10.0;
constexpr double kNoImuNoiseScale = 300.0;
// Bias change that makes an interval worth integrating again.
constexpr double kRelinearizeGyro = 2e-3;   // rad/s
constexpr double kRelinearizeAccel = 2e-2;  // m/s^2
// And change of the gyroscope's scale.
constexpr double kRelinearizeScale = 1e-3;

// Whether the samples can be integrated: finite, in order of time, from t0 to t1 or nearly so.
bool IsUsable(const std::vector<ImuSample>& samples, Timestamp t0, Timestamp t1) {
  constexpr Duration kMaxEndError{10'000'000};
  if (samples.size() < 2 || samples.front().t != t0) return false;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (!samples[i].gyro.allFinite() || !samples[i].accel.allFinite()) return false;
    if (i > 0 && samples[i].t < samples[i - 1].t) return false;
  }
  return std::max(samples.back().t - t1, t1 - samples.back().t) <= kMaxEndError;
}

// What an IMU would have seen at constant velocity.
std::vector<ImuSample> ConstantVelocity(const NavState& x,
                                        const Vector3d& g_W,
                                        Timestamp t0,
                                        Timestamp t1) {
  ImuSample sample{t0, x.bias.b_g, x.bias.b_a - x.T_WB.q.conjugate() * g_W};
  std::vector<ImuSample> samples = {sample, sample};
  samples.back().t = std::max(t0, t1);
  return samples;
}

}  // namespace

ImuIntervals::ImuIntervals(const ImuNoise& noise, const ImuOptions& options, Duration time_offset)
    : parameters_(ParametersInUse(noise, options)),
      bias_walk_(noise, options),
      time_offset_(time_offset) {}

void ImuIntervals::Begin(Timestamp t) {
  end_ = t + time_offset_;
}

PredictedFrame ImuIntervals::Next(const NavState& last,
                                  std::optional<ImuLink> passing,
                                  Timestamp t,
                                  const ImuInterval& imu) {
  const Timestamp t1 = t + time_offset_;
  const bool is_synthetic = !IsUsable(imu.samples, end_, t1);
  std::vector<ImuSample> invented;
  if (is_synthetic) invented = ConstantVelocity(last, parameters_.g_W(), end_, t1);
  const std::span<const ImuSample> samples = is_synthetic ? invented : imu.samples;
  const double scale = is_synthetic ? kNoImuNoiseScale : imu.has_hole ? kGapNoiseScale : 1.0;
  const StepNoise noise{scale, ToSeconds(imu.allowed_gap)};

  PredictedFrame frame;
  frame.link.is_synthetic = is_synthetic;
  ImuPreintegration& measured = frame.link.measured;
  measured = ImuPreintegration(last.bias, parameters_, gyro_scale_);
  measured.Integrate(samples, noise);
  frame.x = measured.Predict(last);
  frame.x.t = t;
  if (passing) {
    measured = std::move(passing->measured);
    measured.Integrate(samples, noise);
  }
  UpdateSqrtInfo(frame.link);
  end_ = samples.back().t;
  return frame;
}

ImuLink ImuIntervals::Join(ImuLink first, const ImuLink& second) const {
  first.measured.Append(second.measured);
  first.is_synthetic = second.is_synthetic;
  UpdateSqrtInfo(first);
  return first;
}

void ImuIntervals::Relinearize(SlidingWindow& window) const {
  const Vector3d gyro_scale = window.GyroScale();
  for (std::size_t j = 1; j < window.frames.size(); ++j) {
    std::optional<ImuLink>& link = window.frames[j].imu_link;
    if (!link) continue;
    const ImuBias& bias = window.frames[j - 1].x.bias;
    const ImuPreintegration& measured = link->measured;
    if ((bias.b_g - measured.bias().b_g).norm() < kRelinearizeGyro &&
        (bias.b_a - measured.bias().b_a).norm() < kRelinearizeAccel &&
        (gyro_scale - measured.gyro_scale()).norm() < kRelinearizeScale) {
      continue;
    }
    link->measured.Reintegrate(bias, gyro_scale);
    UpdateSqrtInfo(*link);
  }
}

void ImuIntervals::UpdateSqrtInfo(ImuLink& link) const {
  link.sqrt_info = ImuSqrtInfo(link.measured, bias_walk_);
}

}  // namespace facet
