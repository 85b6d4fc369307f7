// SPDX-License-Identifier: BSD-2-Clause
// A landmark on a plane: one row, its distance from the plane (docs/math.md, equations (7.1) and
// (7.2); paper, equation (9)). The sigma is WindowPlane::row_sigma_m; Huber's loss.
#pragma once

#include "facet/estimator/factors/factor_noise.h"
#include "facet/estimator/factors/hosted_point.h"
#include "facet/estimator/factors/landmark_block.h"

namespace facet {

/// One landmark that IsOnPlanes on one of its planes. A view of the window, as in factor.h, but one
/// that adds up in a LandmarkBlock.
class PointOnPlaneFactor {
 public:
  PointOnPlaneFactor(const std::vector<WindowPlane>& planes, int index, const FactorNoise& noise)
      : plane_(planes[index]), index_(index), noise_(noise) {}

  /// Whitened distance.
  double Error(const HostedPoint& point) const;

  double Cost(const HostedPoint& point) const;
  void AddTo(const LinearizedPoint& point, LandmarkBlock& block) const;

 private:
  const WindowPlane& plane_;
  int index_;
  const FactorNoise& noise_;
};

}  // namespace facet
