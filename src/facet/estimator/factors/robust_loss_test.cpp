// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/factors/robust_loss.h"

#include <cmath>

#include <gtest/gtest.h>

namespace facet {
namespace {

TEST(RobustLossTest, WeightIsTheDerivativeOfTheCost) {
  for (const double s : {0.1, 0.9, 1.7, 3.0, 4.6}) {
    const double h = 1e-6;
    const double tukey = (TukeyLoss(s + h, 4.685).cost - TukeyLoss(s - h, 4.685).cost) / (2 * h);
    const double huber = (HuberLoss(s + h, 2.0).cost - HuberLoss(s - h, 2.0).cost) / (2 * h);
    EXPECT_NEAR(std::pow(TukeyLoss(s, 4.685).root_weight, 2) * s, tukey, 1e-8);
    EXPECT_NEAR(std::pow(HuberLoss(s, 2.0).root_weight, 2) * s, huber, 1e-8);
    const double geman =
        (GemanMcClureLoss(s + h, 2.0).cost - GemanMcClureLoss(s - h, 2.0).cost) / (2 * h);
    EXPECT_NEAR(std::pow(GemanMcClureLoss(s, 2.0).root_weight, 2) * s, geman, 1e-8);
  }
  EXPECT_NEAR(GemanMcClureLoss(1e-3, 2.0).cost, 0.5e-6, 1e-12);
  EXPECT_NEAR(GemanMcClureLoss(1e6, 2.0).cost, 2.0, 1e-6);
  EXPECT_EQ(TukeyLoss(5.0, 4.685).root_weight, 0);
  EXPECT_NEAR(TukeyLoss(5.0, 4.685).cost, TukeyLoss(4.685, 4.685).cost, 1e-12);
  EXPECT_NEAR(TukeyLoss(1e-3, 4.685).cost, 0.5e-6, 1e-12);
}

}  // namespace
}  // namespace facet
