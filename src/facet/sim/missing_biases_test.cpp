// SPDX-License-Identifier: BSD-2-Clause
#include "facet/sim/missing_biases.h"

#include <limits>

#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/geometry/so3.h"
#include "facet/sim/spline_trajectory.h"

namespace facet {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
const Vector3d kNone = Vector3d::Constant(kNan);
const ImuBias kBias{{-0.003, 0.02, 0.08}, {0.1, -0.05, 0.2}};  // as large as EuRoC's

/// A flight as recorded: poses with 1 mm and 1 mrad of noise and no biases, samples of an IMU with
/// constant ones.
class MissingBiasesTest : public ::testing::Test {
 protected:
  MissingBiasesTest() {
    const SplineTrajectory path = SplineTrajectory::Fit(MakeFlight(20, 1));
    Rng rng(1);
    for (Timestamp t = path.begin(); t <= path.end(); t = t + FromSeconds(0.005)) {
      const ImuSample ideal = path.IdealImuAt(t);
      imu_.push_back({t, ideal.gyro + kBias.b_g, ideal.accel + kBias.b_a});
      NavState state = path.At(t).state;
      state.T_WB.p += 1e-3 * rng.Normal3();
      state.T_WB.q = state.T_WB.q * ExpSO3(1e-3 * rng.Normal3());
      state.bias = {kNone, kNone};
      states_.push_back(state);
    }
  }

  void ExpectFound(double tolerance_accel) {
    const auto found = FillInBiases(imu_, states_);
    ASSERT_TRUE(found);
    EXPECT_LT((found->b_g - kBias.b_g).norm(), 3e-4);  // 1 mrad at both ends
    EXPECT_LT((found->b_a - kBias.b_a).norm(), tolerance_accel);
    for (const NavState& state : states_) {
      EXPECT_EQ(state.bias.b_g, found->b_g);
      EXPECT_EQ(state.bias.b_a, found->b_a);
    }
  }

  std::vector<ImuSample> imu_;
  std::vector<NavState> states_;
};

TEST_F(MissingBiasesTest, ConstantsThatFit) {
  ExpectFound(0.02);
}

TEST_F(MissingBiasesTest, TheRecordMayBeTilted) {
  const SE3 tilt(ExpSO3(Vector3d(0.004, 0.003, 0)), Vector3d::Zero());  // 0.05 m/s^2
  for (NavState& state : states_)
    state.T_WB = tilt * state.T_WB;
  ExpectFound(0.03);
}

TEST_F(MissingBiasesTest, GapsDoNotCount) {
  states_.erase(states_.begin() + 1200, states_.begin() + 1800);
  ExpectFound(0.05);
}

TEST_F(MissingBiasesTest, WhatSomeRowsTellIsKept) {
  states_[1000].bias = {{1, 2, 3}, kNone};
  states_[2000].bias = {{4, 5, 6}, kNone};
  const auto found = FillInBiases(imu_, states_);
  ASSERT_TRUE(found);
  EXPECT_FALSE(found->b_g.allFinite());
  EXPECT_LT((found->b_a - kBias.b_a).norm(), 0.02);
  EXPECT_EQ(states_.front().bias.b_g, Vector3d(1, 2, 3));
  EXPECT_EQ(states_[1999].bias.b_g, Vector3d(1, 2, 3));
  EXPECT_EQ(states_.back().bias.b_g, Vector3d(4, 5, 6));
  EXPECT_EQ(states_.back().bias.b_a, found->b_a);
}

TEST_F(MissingBiasesTest, ZeroIsABias) {
  for (NavState& state : states_)
    state.bias = {};
  EXPECT_FALSE(FillInBiases(imu_, states_));
  EXPECT_EQ(states_.front().bias.b_g, Vector3d(0, 0, 0));
}

}  // namespace
}  // namespace facet
