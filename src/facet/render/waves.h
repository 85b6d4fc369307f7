// SPDX-License-Identifier: BSD-2-Clause
// Shapes of uneven ground and rock.
#pragma once

#include <vector>

#include "facet/base/random.h"

namespace facet {

/// A sum of waves of all sizes; amplitude about 1. Thread-safe (immutable).
class Waves {
 public:
  Waves(double longest_m, int num_octaves, Rng& rng);
  double At(const Vector3d& x) const;

 private:
  struct Wave {
    Vector3d k;
    double phase = 0, amplitude = 0;
  };
  std::vector<Wave> waves_;
};

}  // namespace facet
