// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/solver/window_optimizer.h"

#include <gtest/gtest.h>

#include "facet/testing/estimator/test_window.h"

namespace facet {
namespace {

TEST(WindowOptimizerTest, TheLossFollowsTheErrorsThatWereMet) {
  Rng rng(1);
  testing::TestWindowOptions window_options;
  window_options.noise = 0.4;
  testing::TestWindow test = testing::MakeTestWindow(window_options, rng);
  EstimatorOptions options;
  options.solver.loss_width = 4;
  WindowOptimizer optimizer(test.rig, options);
  EXPECT_EQ(optimizer.noise().reprojection_width, 4);
  OutlierRemoval removal;
  for (int i = 0; i < 20; ++i) {
    const double before = optimizer.noise().reprojection_width;
    removal = optimizer.RemoveOutliers(test.window);
    EXPECT_EQ(optimizer.noise().reprojection_width, before) << "not yet";
    optimizer.LearnFrom(removal);
    EXPECT_LT(optimizer.noise().reprojection_width, before);
  }
  ASSERT_TRUE(removal.median_sigma);
  EXPECT_NEAR(optimizer.noise().reprojection_width, 4 * *removal.median_sigma, 0.05);
}

TEST(WindowOptimizerTest, WithoutLandmarksThereIsNothingToLearn) {
  Rng rng(2);
  testing::TestWindowOptions window_options;
  window_options.num_landmarks = 0;
  testing::TestWindow test = testing::MakeTestWindow(window_options, rng);
  WindowOptimizer optimizer(test.rig, EstimatorOptions{});
  const double before = optimizer.noise().reprojection_width;
  optimizer.LearnFrom(optimizer.RemoveOutliers(test.window));
  EXPECT_EQ(optimizer.noise().reprojection_width, before);
}

TEST(WindowOptimizerTest, OptionsOtherThanTheWidthStay) {
  Rng rng(3);
  testing::TestWindow test = testing::MakeTestWindow({}, rng);
  EstimatorOptions options;
  options.planes.relations.sigma_deg = 7;
  options.solver.plane_sigma_m = 0.3;
  options.projection.sigma_px = 2.5;
  WindowOptimizer optimizer(test.rig, options);
  optimizer.LearnFrom(optimizer.RemoveOutliers(test.window));
  EXPECT_EQ(optimizer.noise().relations.sigma_rad, 7 * kDegree);
  EXPECT_EQ(optimizer.noise().plane_sigma_m, 0.3);
  EXPECT_EQ(optimizer.noise().projection.sigma_px, 2.5);
}

}  // namespace
}  // namespace facet
