// SPDX-License-Identifier: BSD-2-Clause
// How far off reprojections usually are. The front end's sigmas also hold what no residual shows
// (calibration, errors that stay the same from frame to frame), so by them alone a track that
// slides along an edge is no outlier; by what the other tracks do it is.
#pragma once

#include <algorithm>

namespace facet {

class ResidualScale {
 public:
  /// Median over the window of the whitened reprojection errors' norms, after a keyframe's solve.
  void Add(double median_sigma) {
    sigma_ += kRate * (std::clamp(median_sigma, kMin, kMax) - sigma_);
  }

  /// Smoothed over about a second; before the first one: what noise of one sigma gives.
  double sigma() const { return sigma_; }

 private:
  static constexpr double kRate = 0.2;
  // Perfect images and broken calibrations: neither makes the loss useless.
  static constexpr double kMin = 0.2;
  static constexpr double kMax = 2.0;

  double sigma_ = 1.0;
};

}  // namespace facet
