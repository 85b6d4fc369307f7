// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/stated_covariance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <gtest/gtest.h>

namespace facet {
namespace {

constexpr double kOfShakingImu = 0.12, kLeast = 0.2, kMost = 25;

// Of a run that has just begun: all of it is counted as it is now.
double OfPosition(StatedCovariance stated) {
  const Matrix<15, 15> solved = 1e6 * Matrix<15, 15>::Identity();
  stated.AddKeyframe(solved);
  return stated.Of(solved)(3, 3) / solved(3, 3);
}

Matrix<15, 15> Solved(double position_variance) {
  Matrix<15, 15> solved = 1e-4 * Matrix<15, 15>::Identity();
  solved.block<3, 3>(3, 3) = position_variance * Matrix3d::Identity();
  return solved;
}

TEST(StatedCovarianceTest, IsThatOfTheSolveBeforeAnythingIsKnown) {
  EXPECT_EQ(StatedCovariance(8).Of(Solved(1)), Solved(1));
  EXPECT_EQ(OfPosition(StatedCovariance(8)), 1);
}

TEST(StatedCovarianceTest, NobodyKnowsTheAxesOfTheBodyBetterThanTheImuHasThem) {
  constexpr double kAxesSigma = 1e-3;
  StatedCovariance stated(8, kAxesSigma);
  for (int i = 0; i < 1000; ++i)
    stated.AddImuError(0);
  Matrix<15, 15> of_axes = Matrix<15, 15>::Zero();
  of_axes.topLeftCorner<3, 3>() = kAxesSigma * kAxesSigma * Matrix3d::Identity();
  EXPECT_LT((stated.Of(Matrix<15, 15>::Zero()) - of_axes).norm(), 1e-15);
}

TEST(StatedCovarianceTest, FollowsAQuietImuAndCountsWhatItBelievedBefore) {
  for (const double share : {0.5, 0.01}) {
    StatedCovariance stated(8);
    for (int i = 1; i <= 200; ++i) {
      stated.AddImuError(share * kOfShakingImu);
      const double expected = (25 + i * share) / (25 + i);
      EXPECT_NEAR(OfPosition(stated), std::max(expected, kLeast), 1e-5) << share << ", " << i;
    }
  }
}

TEST(StatedCovarianceTest, NoImuIsQuieterThanItsCalibration) {
  for (const double scale : {0.5, 1.0, 2.0}) {
    StatedCovariance stated(scale);
    for (int i = 0; i < 1000; ++i)
      stated.AddImuError(0);
    EXPECT_GE(OfPosition(stated), std::min(1.0, 1 / (scale * scale))) << scale;
  }
}

TEST(StatedCovarianceTest, AnImuThatBeginsToShakeIsBelievedWithinTenSeconds) {
  StatedCovariance stated(8);
  for (int i = 0; i < 100'000; ++i)
    stated.AddImuError(0);
  EXPECT_LT(OfPosition(stated), 0.21);
  for (int i = 0; i < 50; ++i)
    stated.AddImuError(kOfShakingImu);
  EXPECT_GT(OfPosition(stated), 0.6);
  for (int i = 0; i < 5000; ++i)
    stated.AddImuError(3 * kOfShakingImu);
  EXPECT_EQ(OfPosition(stated), 1) << "never more than the solve's";
}

TEST(StatedCovarianceTest, OneContradictionIsNoNoise) {
  StatedCovariance stated(8), with_one(8);
  for (int i = 0; i < 100; ++i) {
    stated.AddImuError(0.05);
    with_one.AddImuError(i == 50 ? 1e9 : 0.05);
  }
  EXPECT_LT(OfPosition(with_one), OfPosition(stated) + 1 / kOfShakingImu / 50);
  with_one.AddImuError(std::numeric_limits<double>::infinity());
  with_one.AddImuError(std::numeric_limits<double>::quiet_NaN());
  EXPECT_LT(OfPosition(with_one), OfPosition(stated) + 1 / kOfShakingImu / 50);
}

TEST(StatedCovarianceTest, AWrongCalibrationCountsAsItSurprises) {
  StatedCovariance stated(8);
  const std::pair<double, double> cases[] = {{0.1, 1}, {1, 1}, {4, 4}, {1e9, kMost}};
  for (const auto& [surprise, factor] : cases) {
    stated.SetCalibrationSurprise(surprise);
    EXPECT_DOUBLE_EQ(OfPosition(stated), factor);
  }
  stated.SetCalibrationSurprise(std::numeric_limits<double>::quiet_NaN());
  EXPECT_DOUBLE_EQ(OfPosition(stated), kMost);
}

TEST(StatedCovarianceTest, TheWayKeepsTheFactorsOfItsTime) {
  StatedCovariance stated(8);
  for (int i = 0; i < 500; ++i)
    stated.AddImuError(kOfShakingImu);
  stated.AddKeyframe(Solved(1));
  for (int i = 0; i < 5000; ++i)
    stated.AddImuError(0.05 * kOfShakingImu);
  stated.AddKeyframe(Solved(1));
  EXPECT_NEAR(stated.Of(Solved(1))(3, 3), 1, 0.01) << "landed, and nothing was learnt";
  EXPECT_LT(stated.Of(Solved(1))(6, 6) / Solved(1)(6, 6), 0.21) << "the velocity is of now";
  EXPECT_EQ(stated.Of(Solved(1))(9, 9), Solved(1)(9, 9)) << "biases are as they were";
  stated.AddKeyframe(Solved(4));
  // A quarter was measured as assumed, three quarters as 0.05 of it, after 525 keyframes.
  EXPECT_NEAR(stated.Of(Solved(4))(3, 3), 4 * (25 + 500 * (1 + 3 * 0.05) / 4) / 525, 0.02);
}

TEST(StatedCovarianceTest, ACalibrationWasWrongAllTheWayUntilItIsFreed) {
  StatedCovariance stated(8);
  stated.AddKeyframe(Solved(1));
  stated.SetCalibrationSurprise(5);
  stated.AddKeyframe(Solved(1));
  EXPECT_DOUBLE_EQ(stated.Of(Solved(1))(3, 3), 5);
  stated.SetCalibrationSurprise(0.5);
  stated.AddKeyframe(Solved(1));
  EXPECT_NEAR(stated.Of(Solved(1))(3, 3), 5, 0.01);
  stated.AddKeyframe(Solved(2));
  EXPECT_NEAR(stated.Of(Solved(2))(3, 3), 6, 0.02);
  EXPECT_DOUBLE_EQ(stated.Of(Solved(2))(6, 6), Solved(2)(6, 6));
}

TEST(StatedCovarianceTest, WhatWasBeforeALossKeepsItsFactorAndWhatFollowsHasItsOwn) {
  StatedCovariance stated(8);
  stated.SetCalibrationSurprise(5);
  stated.AddKeyframe(Solved(1));
  EXPECT_EQ(stated.OfOrigin(), 1);
  stated.StartOver();
  EXPECT_DOUBLE_EQ(stated.OfOrigin(), 5);
  stated.SetCalibrationSurprise(1);
  stated.AddKeyframe(Solved(0.01));
  EXPECT_DOUBLE_EQ(stated.Of(Solved(0.01))(3, 3), 0.01);
  EXPECT_DOUBLE_EQ(stated.OfOrigin(), 5);
}

}  // namespace
}  // namespace facet
