// SPDX-License-Identifier: BSD-2-Clause
// Windows whose optimum is known although they have a prior. With first-estimate Jacobians the
// stationary point moves when frozen variables leave their linearisation point; so these windows
// are made such that the optimum lies there (delta = 0), with a gradient of the prior that balances
// all other cost.
#pragma once

#include "facet/testing/estimator/ceres_window.h"

namespace facet::testing {

/// Beyond this many sigma reprojections of these windows count ever less.
inline constexpr double kOptimumWidth = 10.0;

/// The noise of these windows.
inline const FactorNoise kOptimumNoise = NoiseOfWidth(kOptimumWidth);

/// To convergence, with the width of the loss that the noise says.
SolverOptions ExactOptions();

/// Five to seven frames; the oldest `num_pose_frames` have a pose only. One landmark is seen once.
TestWindow MakeOptimumWindow(std::uint64_t seed, int num_pose_frames);

/// Freezes the two oldest frames, and every other plane, where they are, and gives them a random
/// prior of full rank whose gradient balances that of everything else at the optimum given them.
void AddBalancedPrior(TestWindow& test, Rng& rng, const FactorNoise& noise);

}  // namespace facet::testing
