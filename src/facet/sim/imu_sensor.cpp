// SPDX-License-Identifier: BSD-2-Clause
#include "facet/sim/imu_sensor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "facet/sim/vibration.h"

namespace facet {
namespace {

double Measure(double value, double limit, double step) {
  const double clipped = std::clamp(value, -limit, limit);
  return step > 0 ? step * std::round(clipped / step) : clipped;
}

/// Biases of the EuRoC vehicle, different for each seed.
ImuBias DrawBias(Rng& rng) {
  ImuBias bias{Vector3d(-0.0022, 0.0208, 0.0760), Vector3d(-0.013, 0.10, 0.09)};
  bias.b_g += 5e-3 * rng.Normal3();
  bias.b_a += 0.03 * rng.Normal3();
  return bias;
}

}  // namespace

SensedImu SenseImu(const SplineTrajectory& trajectory,
                   Timestamp begin,
                   Timestamp end,
                   const ImuNoise& noise,
                   const ImuSensorOptions& options,
                   VibrationKind vibration,
                   std::uint64_t seed) {
  Rng rng(seed);
  Rng bias_rng(rng.Next()), white_rng(rng.Next()), vibration_rng(rng.Next());
  const double root_rate = std::sqrt(options.rate_hz);
  const double scale = options.add_noise ? 1.0 : 0.0;
  Vibration shaking(vibration, options.rate_hz, vibration_rng);
  ImuBias bias = DrawBias(bias_rng);
  if (!options.add_bias) bias = ImuBias();

  SensedImu imu;
  for (std::int64_t i = 0;; ++i) {
    const Timestamp t = begin + FromSeconds(static_cast<double>(i) / options.rate_hz);
    if (t > end) return imu;
    NavState truth = trajectory.At(t).state;
    truth.bias = bias;
    imu.truth.push_back(truth);
    ImuSample sample = trajectory.IdealImuAt(t);
    const Vector<6> shake = scale * options.vibration * shaking.Next();
    sample.gyro +=
        bias.b_g + scale * noise.gyro_noise * root_rate * white_rng.Normal3() + shake.head<3>();
    sample.accel +=
        bias.b_a + scale * noise.accel_noise * root_rate * white_rng.Normal3() + shake.tail<3>();
    for (int k = 0; k < 3; ++k) {
      sample.gyro(k) = Measure(sample.gyro(k), options.max_gyro, scale * options.gyro_step);
      sample.accel(k) = Measure(sample.accel(k), options.max_accel, scale * options.accel_step);
    }
    imu.samples.push_back(sample);
    if (!options.add_bias) continue;
    bias.b_g += scale * noise.gyro_walk / root_rate * bias_rng.Normal3();
    bias.b_a += scale * noise.accel_walk / root_rate * bias_rng.Normal3();
  }
}

}  // namespace facet
