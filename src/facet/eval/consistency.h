// SPDX-License-Identifier: BSD-2-Clause
// Are the uncertainties that a run states true? Normalised errors of states.csv against ground
// truth that has more than poses.
#pragma once

#include <optional>
#include <span>

#include "facet/io/states_file.h"

namespace facet {

/// Errors of one part of the state over all frames. 1 is right, above: overconfident.
struct NormalizedErrors {
  std::size_t num_states = 0;
  /// Mean over frames and axes of (error / sigma)^2: the NEES of the part over its dimension. Axes
  /// may be correlated, the mean is the same.
  double nees = 0;
  /// Median over the frames; 0.79 where errors are Gaussian. Far below the mean: a few frames are
  /// much worse than the rest.
  double nees_median = 0;
  double within_two_sigma = 0;  ///< share of frames and axes; 0.954 where errors are Gaussian
  double rmse = 0;              ///< of the error's norm [m, rad, m/s, rad/s, m/s^2]
};

/// Parts without truth, or whose sigma nobody stated, are absent; a bias without sigma has an rmse
/// and neither of the other two.
struct ConsistencyError {
  std::optional<NormalizedErrors> position, orientation, velocity;
  std::optional<NormalizedErrors> gyro_bias, accel_bias;
};

/// The truth is moved into W by heading and position at the first state that has a truth, because
/// that is where the run's uncertainty begins; what is later than 0.2 s after it counts. Truth is
/// interpolated linearly, and never over more than 0.1 s. Both are sorted by stamp.
ConsistencyError EvaluateConsistency(std::span<const EstimatedState> estimate,
                                     std::span<const NavState> truth_G);

}  // namespace facet
