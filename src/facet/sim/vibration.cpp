// SPDX-License-Identifier: BSD-2-Clause
#include "facet/sim/vibration.h"

#include <cmath>
#include <numbers>

namespace facet {
namespace {

constexpr std::size_t kNumBands = 5;
struct Band {
  double low_hz, high_hz;
};
constexpr std::array<Band, kNumBands> kBands = {
    {{10, 20}, {20, 40}, {40, 60}, {60, 80}, {80, 100}}};

/// 1-sigma by axis (gyro x y z, accelerometer x y z) and band; printed for a recording by
/// scripts/imu_spectra.py.
using Strengths = std::array<std::array<double, kNumBands>, 6>;
constexpr Strengths kRotors = {{{0.0099, 0.0170, 0.0027, 0.0029, 0.0074},
                                {0.0281, 0.0102, 0.0059, 0.0108, 0.0360},
                                {0.0247, 0.0142, 0.0040, 0.0059, 0.0185},
                                {0.290, 0.256, 0.269, 0.366, 0.890},
                                {0.085, 0.302, 0.125, 0.203, 0.319},
                                {0.134, 0.192, 0.204, 0.249, 0.677}}};
constexpr Strengths kHand = {{{0.0132, 0.0026, 0.0005, 0.0002, 0.0002},
                              {0.0048, 0.0032, 0.0005, 0.0008, 0.0002},
                              {0.0192, 0.0045, 0.0006, 0.0003, 0.0002},
                              {0.142, 0.042, 0.010, 0.017, 0.003},
                              {0.118, 0.039, 0.010, 0.015, 0.003},
                              {0.079, 0.019, 0.007, 0.009, 0.002}}};

}  // namespace

double Vibration::Filter::Next(double x) {
  const double y = gain * (x - x2) - a1 * y1 - a2 * y2;
  x2 = x1;
  x1 = x;
  y2 = y1;
  y1 = y;
  return y;
}

Vibration::Vibration(VibrationKind kind, double rate_hz, Rng rng) : rng_(rng) {
  const Strengths& strengths = kind == VibrationKind::kRotors ? kRotors : kHand;
  for (int axis = 0; axis < 6; ++axis) {
    for (std::size_t b = 0; b < kNumBands; ++b) {
      const double center_hz = 0.5 * (kBands[b].low_hz + kBands[b].high_hz);
      const double width_hz = kBands[b].high_hz - kBands[b].low_hz;
      if (center_hz > 0.48 * rate_hz) continue;
      Filter filter;
      filter.axis = axis;
      const double radius = std::exp(-std::numbers::pi * 0.5 * width_hz / rate_hz);
      filter.a1 = -2 * radius * std::cos(2 * std::numbers::pi * center_hz / rate_hz);
      filter.a2 = radius * radius;
      filter.gain = 1;
      // Strength of the response to white noise: the energy of the impulse response.
      double energy = 0;
      Filter probe = filter;
      for (int i = 0; i < 4000; ++i) {
        const double y = probe.Next(i == 0 ? 1 : 0);
        energy += y * y;
      }
      filter.gain = strengths[static_cast<std::size_t>(axis)][b] / std::sqrt(energy);
      filters_.push_back(filter);
    }
  }
  for (int i = 0; i < 200; ++i)  // past the transient
    Next();
}

Vector<6> Vibration::Next() {
  Vector<6> sum = Vector<6>::Zero();
  for (Filter& filter : filters_)
    sum(filter.axis) += filter.Next(rng_.Normal());
  return sum;
}

}  // namespace facet
