// SPDX-License-Identifier: BSD-2-Clause
// Random numbers that are the same on every machine and standard library (std::normal_distribution
// is not).
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include "facet/base/types.h"

namespace facet {

/// SplitMix64 with Box-Muller normals. Value type; copy it to fork a stream.
class Rng {
 public:
  explicit Rng(std::uint64_t seed) : state_(seed) { Next(); }

  std::uint64_t Next() {
    std::uint64_t z = (state_ += 0x9E3779B97F4A7C15ULL);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return z ^ (z >> 31);
  }

  /// Uniform in [0, 1).
  double Uniform() { return static_cast<double>(Next() >> 11) * 0x1.0p-53; }
  double Uniform(double low, double high) { return low + (high - low) * Uniform(); }

  /// Uniform integer in [0, n).
  int Index(int n) { return static_cast<int>(Next() % static_cast<std::uint64_t>(n)); }

  double Normal() {
    const double u = 1.0 - Uniform();
    const double angle = 2.0 * std::numbers::pi * Uniform();
    return std::sqrt(-2.0 * std::log(u)) * std::cos(angle);
  }

  Vector3d Normal3() {
    const double x = Normal(), y = Normal(), z = Normal();
    return {x, y, z};
  }

  Vector3d UnitVector() { return Normal3().normalized(); }

 private:
  std::uint64_t state_;
};

}  // namespace facet
