// SPDX-License-Identifier: BSD-2-Clause
// Observations that do not fit the window after its solve are taken out of it.
#pragma once

#include <optional>
#include <vector>

#include "facet/estimator/factors/factor_noise.h"
#include "facet/estimator/window/frame_geometry.h"
#include "facet/estimator/window/sliding_window.h"

namespace facet {

struct OutlierRemoval {
  int num_removed = 0;  ///< observations, without those of landmarks that went as a whole
  /// Median of the norms of the whitened left errors, outliers too; empty without landmarks.
  std::optional<double> median_sigma;
};

/// Not thread-safe: keeps its storage.
class OutlierRemover {
 public:
  /// Removes observations that are off by more than `max_sigma`, with what the robust loss and the
  /// noise of projections say; a landmark without any, and one nearer than a few centimetres, goes
  /// as a whole. A landmark that loses its host's observation gets another host. Landmarks that do
  /// not constrain the window are left alone. `geometry` must be up to date.
  OutlierRemoval Remove(const FrameGeometry& geometry,
                        const FactorNoise& noise,
                        double max_sigma,
                        SlidingWindow& window);

 private:
  int RemoveFrom(const FrameGeometry& geometry,
                 const FactorNoise& noise,
                 double max_sigma,
                 WindowLandmark& landmark);

  std::vector<double> left_sigmas_;  // of the left errors that count for the median
};

}  // namespace facet
