// SPDX-License-Identifier: BSD-2-Clause
// Robust losses for iteratively reweighted least squares (docs/math.md, section 4.1). `s` is the
// norm of the whitened rows that are weighted together.
#pragma once

#include <cmath>

namespace facet {

struct RobustLoss {
  double cost = 0;         ///< rho(s); s^2 / 2 near zero
  double root_weight = 1;  ///< sqrt(rho'(s) / s): multiplies rows and residual
};

/// Linear beyond k.
inline RobustLoss HuberLoss(double s, double k) {
  if (s <= k) return {0.5 * s * s, 1.0};
  return {k * (s - 0.5 * k), std::sqrt(k / s)};
}

/// Nearly constant beyond a few c (Geman-McClure): what is far off hardly pulls any more.
inline RobustLoss GemanMcClureLoss(double s, double c) {
  const double root_weight = 1 / (1 + (s / c) * (s / c));
  return {0.5 * s * s * root_weight, root_weight};
}

/// Constant beyond c.
inline RobustLoss TukeyLoss(double s, double c) {
  if (s >= c) return {c * c / 6, 0.0};
  const double root_weight = 1 - (s / c) * (s / c);
  return {c * c / 6 * (1 - root_weight * root_weight * root_weight), root_weight};
}

}  // namespace facet
