// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/solver/linearized_window.h"

#include <gtest/gtest.h>

#include "facet/testing/estimator/balanced_prior.h"

namespace facet {
namespace {

using testing::TestWindow;

const FactorNoise kNoise = testing::NoiseOfWidth(testing::kOptimumWidth);

TEST(LinearizedWindowTest, CostIsTheSameWithAndWithoutLinearizing) {
  TestWindow test = testing::MakeOptimumWindow(52, 0);
  Rng rng(52);
  testing::AddBalancedPrior(test, rng, kNoise);
  testing::Disturb(test.window, {}, rng);
  LinearizedWindow linear;
  testing::Linearize(test, kNoise, linear);
  FrameGeometry geometry(test.rig);
  geometry.Update(test.window.frames);
  EXPECT_NEAR(WindowCost(test.window, geometry, kNoise), linear.cost, 1e-9 * linear.cost);
}

}  // namespace
}  // namespace facet
