// SPDX-License-Identifier: BSD-2-Clause
#include "facet/render/waves.h"

#include <cmath>
#include <numbers>

namespace facet {

Waves::Waves(double longest_m, int num_octaves, Rng& rng) {
  constexpr double kTurn = 2 * std::numbers::pi;
  for (int octave = 0; octave < num_octaves; ++octave) {
    for (int i = 0; i < 3; ++i) {
      const double frequency = kTurn / longest_m * std::pow(1.9, octave);
      waves_.push_back(
          {frequency * rng.UnitVector(), rng.Uniform(0, kTurn), 0.45 * std::pow(1.75, -octave)});
    }
  }
}

double Waves::At(const Vector3d& x) const {
  double sum = 0;
  for (const Wave& w : waves_)
    sum += w.amplitude * std::sin(w.k.dot(x) + w.phase);
  return sum;
}

}  // namespace facet
