// SPDX-License-Identifier: BSD-2-Clause
// The cost of a sliding window once more, for Ceres: written from the formulas, without the code
// under test. Landmarks are points of the world, derivatives automatic.
#pragma once

#include <array>
#include <vector>

#include "facet/testing/estimator/test_window.h"

namespace facet::testing {

struct CeresOptions {
  FactorNoise noise;
  /// Variables of the window's prior are held.
  bool hold_prior_variables = false;
};

struct CeresResult {
  double cost = 0;
  std::vector<NavState> states;  ///< by frame
  std::vector<Vector3d> points;  ///< by landmark
  std::vector<Vector4d> planes;  ///< by plane: normal, offset from the anchor
  VectorXd prior_gradient;       ///< of all cost but the prior, on the variables of the prior
};

/// Minimises from the present estimate to convergence. All landmarks must have inverse distance >
/// 0.
CeresResult SolveWithCeres(const SlidingWindow& window,
                           const StereoRig& rig,
                           const CeresOptions& options);

}  // namespace facet::testing
