// SPDX-License-Identifier: BSD-2-Clause
// What rotors or hands add to the readings of an IMU, by bands of frequency.
#pragma once

#include <array>
#include <vector>

#include "facet/base/random.h"
#include "facet/sim/imu_sensor.h"

namespace facet {

/// Gaussian noise whose strength in each band and axis is that of the EuRoC recordings (rotors:
/// mean of V1_01, V1_02 and MH_05 in flight; hand: MH_01 before take-off). Not thread-safe.
class Vibration {
 public:
  Vibration(VibrationKind kind, double rate_hz, Rng rng);

  /// The next sample: gyro x y z [rad/s], accelerometer x y z [m/s^2].
  Vector<6> Next();

 private:
  /// Two equal resonances (band-passes) in series, scaled so that white noise of unit strength
  /// comes out with a given standard deviation.
  struct Filter {
    struct Past {
      double x1 = 0, x2 = 0, y1 = 0, y2 = 0;
    };
    int axis = 0;
    double a1 = 0, a2 = 0, gain = 0;
    std::array<Past, 2> past;
    double Next(double x);
    /// Squared gain at a frequency, given in cycles per sample, without the factor `gain`.
    double Power(double cycles) const;
  };

  std::vector<Filter> filters_;
  Rng rng_;
};

}  // namespace facet
