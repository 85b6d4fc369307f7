// SPDX-License-Identifier: BSD-2-Clause
// An IMU as it flies: white noise, bias walks, the vibration of rotors, saturation and steps.
#pragma once

#include <vector>

#include "facet/base/options.h"
#include "facet/base/random.h"
#include "facet/sim/spline_trajectory.h"

namespace facet {

/// The defaults are those of the ADIS16448 of the EuRoC vehicle.
struct ImuSensorOptions {
  bool add_noise = true;        ///< white noise, bias walks and vibration
  bool add_bias = true;         ///< false: the biases are zero
  double vibration = 1;         ///< factor on the vibration measured on EuRoC's flights
  double max_gyro = 17.45;      ///< [rad/s]; beyond it the sample shows this value
  double max_accel = 176.6;     ///< [m/s^2]
  double gyro_step = 6.98e-4;   ///< smallest difference between samples [rad/s]; 0: none
  double accel_step = 8.17e-3;  ///< [m/s^2]
  double rate_hz = 200;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("add_noise", add_noise, "white noise, bias walks and vibration");
    v.Field("add_bias", add_bias, "false: no bias at all");
    v.Field(
        "vibration", vibration, Range{0, 100}, "factor on what was measured on EuRoC's flights");
    v.Field("max_gyro", max_gyro, Range{0.1, 1e4}, "saturation, rad/s");
    v.Field("max_accel", max_accel, Range{1, 1e5}, "saturation, m/s^2");
    v.Field("gyro_step", gyro_step, Range{0, 1}, "resolution, rad/s; 0: none");
    v.Field("accel_step", accel_step, Range{0, 10}, "resolution, m/s^2; 0: none");
    v.Field("rate_hz", rate_hz, Range{50, 4000}, "samples per second");
  }
};

/// How the IMU is shaken.
enum class VibrationKind { kRotors, kHand };

struct SensedImu {
  std::vector<ImuSample> samples;
  std::vector<NavState> truth;  ///< at the stamps of the samples, with the true biases
};

/// Samples from `begin` to `end`, both included if a sample falls there. Noise and biases come from
/// `seed`. CHECKs that the trajectory covers the interval.
SensedImu SenseImu(const SplineTrajectory& trajectory,
                   Timestamp begin,
                   Timestamp end,
                   const ImuNoise& noise,
                   const ImuSensorOptions& options,
                   VibrationKind vibration,
                   std::uint64_t seed);

}  // namespace facet
