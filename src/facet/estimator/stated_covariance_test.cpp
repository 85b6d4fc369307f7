// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/stated_covariance.h"

#include <algorithm>
#include <limits>
#include <utility>

#include <gtest/gtest.h>

namespace facet {
namespace {

constexpr double kOfShakingImu = 0.12, kLeast = 0.2, kMost = 25;

const Matrix<15, 15> kCovariance = 4e-4 * Matrix<15, 15>::Identity();

double Factor(const StatedCovariance& stated) {
  return stated.Of(kCovariance)(3, 3) / kCovariance(3, 3);
}

TEST(StatedCovarianceTest, IsThatOfTheSolveBeforeAnythingIsKnown) {
  EXPECT_EQ(StatedCovariance(8).Of(kCovariance), kCovariance);
}

TEST(StatedCovarianceTest, FollowsAQuietImuWithinSecondsAndNotBelowItsLeast) {
  for (const double share : {0.5, 0.01}) {
    StatedCovariance stated(8);
    double before = 1;
    for (int i = 0; i < 200; ++i) {
      stated.AddImuError(share * kOfShakingImu);
      EXPECT_LE(Factor(stated), before);
      before = Factor(stated);
    }
    EXPECT_NEAR(before, std::max(share, kLeast), 0.1) << share;
    EXPECT_GT(before, 0.99 * kLeast);
  }
}

TEST(StatedCovarianceTest, NoImuIsQuieterThanItsCalibration) {
  for (const double scale : {0.5, 1.0, 2.0}) {
    StatedCovariance stated(scale);
    for (int i = 0; i < 1000; ++i)
      stated.AddImuError(0);
    EXPECT_DOUBLE_EQ(Factor(stated), std::min(1.0, 1 / (scale * scale))) << scale;
  }
}

TEST(StatedCovarianceTest, AnImuThatBeginsToShakeIsNoticedAfterHours) {
  StatedCovariance stated(8);
  for (int i = 0; i < 100'000; ++i)
    stated.AddImuError(0.01);
  EXPECT_NEAR(Factor(stated), kLeast, 1e-9);
  for (int i = 0; i < 500; ++i)
    stated.AddImuError(2 * kOfShakingImu);
  EXPECT_NEAR(Factor(stated), 1, 1e-9) << "never more than the solve's";
}

TEST(StatedCovarianceTest, OneContradictionIsNoNoise) {
  StatedCovariance stated(8);
  for (int i = 0; i < 100; ++i)
    stated.AddImuError(0.01);
  const double before = Factor(stated);
  stated.AddImuError(1e9);
  EXPECT_LT(Factor(stated), before + 0.1);
  stated.AddImuError(std::numeric_limits<double>::infinity());
  stated.AddImuError(std::numeric_limits<double>::quiet_NaN());
  EXPECT_LT(Factor(stated), before + 0.1);
}

TEST(StatedCovarianceTest, AWrongCalibrationCountsAsItSurprises) {
  StatedCovariance stated(8);
  const std::pair<double, double> cases[] = {{0.1, 1}, {1, 1}, {4, 4}, {1e9, kMost}};
  for (const auto& [surprise, factor] : cases) {
    stated.SetCalibrationSurprise(surprise);
    EXPECT_DOUBLE_EQ(Factor(stated), factor);
  }
  stated.SetCalibrationSurprise(std::numeric_limits<double>::quiet_NaN());
  EXPECT_DOUBLE_EQ(Factor(stated), kMost);
}

TEST(StatedCovarianceTest, WhereAWrongCalibrationHasLedToStaysWhenItIsFreed) {
  StatedCovariance stated(8);
  stated.SetCalibrationSurprise(5);
  const Matrix<15, 15> before = stated.Of(kCovariance);
  stated.CalibrationIsFreed(kCovariance);
  stated.SetCalibrationSurprise(0.5);
  const Matrix<15, 15> after = stated.Of(kCovariance);
  EXPECT_TRUE((after.block<3, 3>(3, 3)).isApprox(before.block<3, 3>(3, 3), 1e-12));
  EXPECT_DOUBLE_EQ(after(0, 0), kCovariance(0, 0)) << "angles and velocities are found anew";
  EXPECT_DOUBLE_EQ(after(6, 6), kCovariance(6, 6));
}

}  // namespace
}  // namespace facet
