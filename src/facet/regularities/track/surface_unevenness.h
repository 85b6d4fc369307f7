// SPDX-License-Identifier: BSD-2-Clause
// How far the surface of a plane is from flat.
#pragma once

#include <cmath>

namespace facet {

/// From how landmarks lie about the plane that fits them best, where vision alone sees them: what
/// they scatter beyond the errors of vision. Of nearly all walls and floors nothing is left, of
/// rough ground and of patches that are no planes 4 to 25 mm. Newer keyframes count more.
class SurfaceUnevenness {
 public:
  /// The landmarks of one keyframe: their squared distances less the variance of vision [m^2], each
  /// times its weight, and the sum of the weights.
  void Add(double weighted_excess, double weight) {
    excess_ = kFade * excess_ + weighted_excess;
    weight_ = kFade * weight_ + weight;
  }

  /// 1-sigma [m]; 0 where nothing can be told from a flat surface.
  double sigma_m() const { return excess_ > 0 ? std::sqrt(excess_ / weight_) : 0; }

 private:
  static constexpr double kFade = 0.95;
  double excess_ = 0, weight_ = 0;
};

}  // namespace facet
