// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/factors/start_prior_factor.h"

#include <gtest/gtest.h>

#include "facet/testing/estimator/test_window.h"
#include "facet/testing/numeric_jacobian.h"

namespace facet {
namespace {

using testing::TestWindow;

TEST(StartPriorFactorTest, GradientMatchesTheCost) {
  Rng rng(50);
  TestWindow test = testing::MakeTestWindow({}, rng);
  test.window.start_prior.emplace(FrameId{0}, test.truth[0].T_WB, StartOptions{});
  test.window.start_prior->sigma_position = test.window.start_prior->sigma_yaw = 0.1;
  testing::Disturb(test.window, {0.4, 0.2, 0.2, 0.01, 0.1}, rng);
  NormalEquations equations;
  equations.Clear(test.window);
  const double cost_here = StartPriorFactor(test.window).AddTo(equations);
  EXPECT_EQ(cost_here, StartPriorFactor(test.window).Cost());
  const StateLayout& layout = equations.layout;
  const VectorXd& b = equations.b;
  Matrix<1, 15> gradient;
  gradient << b.segment<6>(layout.pose_column[0]).transpose(),
      b.segment<9>(layout.motion_column[0]).transpose();
  const auto cost = [&](const Vector<15>& d) {
    SlidingWindow moved = test.window;
    moved.frames[0].x = testing::Retract(moved.frames[0].x, d);
    return Vector<1>(StartPriorFactor(moved).Cost());
  };
  testing::ExpectJacobian<1, 15>(gradient, cost, 1e-7);
}

}  // namespace
}  // namespace facet
