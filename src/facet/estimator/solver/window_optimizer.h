// SPDX-License-Identifier: BSD-2-Clause
// Optimises the window, keyframe after keyframe: solves it, takes out the observations that do not
// fit, and learns how far off the others usually are, which says how wide the loss must be.
#pragma once

#include "facet/estimator/solver/outlier_removal.h"
#include "facet/estimator/solver/window_solver.h"

namespace facet {

/// Not thread-safe.
class WindowOptimizer {
 public:
  WindowOptimizer(const StereoRig& rig, const EstimatorOptions& options);

  /// The weights of all factors at present.
  const FactorNoise& noise() const { return noise_; }

  /// Where the cameras are by the window's present estimate.
  const FrameGeometry& UpdateGeometry(const SlidingWindow& window);
  const FrameGeometry& geometry() const { return geometry_; }

  SolveSummary Solve(SlidingWindow& window, int max_iterations) {
    return solver_.Solve(window, noise_, max_iterations);
  }

  /// The solver as the last Solve left it; it answers questions about covariances.
  WindowSolver& solver() { return solver_; }

  /// Removes what does not fit after a solve; updates the geometry.
  OutlierRemoval RemoveOutliers(SlidingWindow& window);

  /// From here on the loss is as wide as the errors that the removal met.
  void LearnFrom(const OutlierRemoval& removal);

 private:
  EstimatorOptions options_;
  ResidualScale residual_scale_;
  FactorNoise noise_;
  WindowSolver solver_;
  FrameGeometry geometry_;
  OutlierRemover outlier_remover_;
};

}  // namespace facet
