// SPDX-License-Identifier: BSD-2-Clause
// A landmark on a plane: one row, its distance from the plane (docs/math.md, equations (7.1) and
// (7.2); paper, equation (9)). The sigma is WindowPlane::row_sigma_m times PlaneLinks::row_scale;
// Huber's loss.
#pragma once

#include "facet/estimator/factors/factor_noise.h"
#include "facet/estimator/factors/hosted_point.h"
#include "facet/estimator/factors/landmark_block.h"

namespace facet {

/// One landmark that IsOnPlanes on the `link`-th of its planes. A view of the window, as in
/// factor.h, but one that adds up in a LandmarkBlock.
class PointOnPlaneFactor {
 public:
  PointOnPlaneFactor(const std::vector<WindowPlane>& planes,
                     const PlaneLinks& links,
                     int link,
                     const FactorNoise& noise)
      : plane_(planes[links[link]]),
        index_(links[link]),
        sigma_m_(plane_.row_sigma_m * links.row_scale(link)),
        noise_(noise) {}

  /// Whitened distance.
  double Error(const HostedPoint& point) const;

  double Cost(const HostedPoint& point) const;
  void AddTo(const LinearizedPoint& point, LandmarkBlock& block) const;

 private:
  const WindowPlane& plane_;
  int index_;
  double sigma_m_;
  const FactorNoise& noise_;
};

}  // namespace facet
