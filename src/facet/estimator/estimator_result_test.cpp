// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/estimator_result.h"

#include <cmath>

#include <gtest/gtest.h>

namespace facet {
namespace {

constexpr int kMany = 100;

EstimatorResult Judge(const NavState& x, double sigma, int num_landmarks, bool has_imu) {
  EstimatorResult result;
  result.reason = "collecting frames";
  SetState(x, sigma * sigma * Matrix<15, 15>::Identity(), num_landmarks, has_imu, result);
  return result;
}

TEST(EstimatorResultTest, AGoodStateNeedsNoReason) {
  NavState x;
  x.T_WB.p = Vector3d(1, 2, 3);
  const EstimatorResult result = Judge(x, 0.1, kMany, true);
  EXPECT_EQ(result.status, TrackingStatus::kOk);
  EXPECT_TRUE(result.has_state);
  EXPECT_TRUE(result.reason.empty());
  EXPECT_EQ(result.state.T_WB.p, x.T_WB.p);
  EXPECT_EQ(result.num_constraining, kMany);
}

TEST(EstimatorResultTest, SaysWhatDegradesIt) {
  EXPECT_EQ(Judge({}, 0.1, 3, true).reason, "few landmarks");
  EXPECT_EQ(Judge({}, 0.1, kMany, false).reason, "no IMU");
  EXPECT_EQ(Judge({}, 0.1, kMany, false).status, TrackingStatus::kDegraded);
}

TEST(EstimatorResultTest, AStateOfNoUseIsLost) {
  EXPECT_EQ(Judge({}, 10, kMany, true).status, TrackingStatus::kLost);
  EXPECT_FALSE(Judge({}, 10, kMany, true).has_state);
  NavState fast, broken;
  fast.v_WB = Vector3d(0, 200, 0);
  EXPECT_EQ(Judge(fast, 0.1, kMany, true).reason, "velocity unknown");
  broken.bias.b_a.x() = std::nan("");
  EXPECT_EQ(Judge(broken, 0.1, kMany, true).reason, "numerical failure");
  EXPECT_FALSE(Judge(broken, 0.1, kMany, true).has_state);
}

}  // namespace
}  // namespace facet
