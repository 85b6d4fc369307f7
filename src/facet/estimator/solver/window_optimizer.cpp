// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/solver/window_optimizer.h"

namespace facet {

WindowOptimizer::WindowOptimizer(const StereoRig& rig, const EstimatorOptions& options)
    : options_(options), noise_(options), solver_(rig, options.solver), geometry_(rig) {}

const FrameGeometry& WindowOptimizer::UpdateGeometry(const SlidingWindow& window) {
  geometry_.Update(window);
  return geometry_;
}

OutlierRemoval WindowOptimizer::RemoveOutliers(SlidingWindow& window) {
  return outlier_remover_.Remove(
      UpdateGeometry(window), noise_, options_.solver.outlier_sigma, window);
}

void WindowOptimizer::LearnFrom(const OutlierRemoval& removal) {
  if (!removal.median_sigma) return;
  residual_scale_.Add(*removal.median_sigma);
  noise_ = FactorNoise(options_, residual_scale_);
}

}  // namespace facet
