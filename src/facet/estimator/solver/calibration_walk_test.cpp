// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/solver/calibration_walk.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "facet/base/random.h"

namespace facet {
namespace {

constexpr int kPose = 6, kDim = kPose + kNumCalibration;

// What is known of a pose and of the calibration, with everything correlated.
MarginalPrior MakePrior() {
  Rng rng(7);
  MatrixXd A(2 * kDim, kDim);
  for (double& a : A.reshaped())
    a = rng.Normal();
  VectorXd mean(kDim);
  for (double& m : mean)
    m = rng.Normal();
  MarginalPrior prior;
  prior.blocks = {MarginalPrior::Block::OfPose(FrameId{1}, 0),
                  MarginalPrior::Block::OfCalibration(kPose)};
  prior.H = A.transpose() * A;
  prior.b = -prior.H * mean;
  return prior;
}

// The mean of a quadratic 1/2 x^T H x + b^T x.
VectorXd MeanOf(const MarginalPrior& prior) {
  return -prior.H.ldlt().solve(prior.b);
}

TEST(CalibrationWalkTest, AddsTheStepsCovarianceAndMovesNoMean) {
  const MarginalPrior before = MakePrior();
  CalibrationMatrix step = CalibrationMatrix::Zero();
  for (int i = 0; i < kNumCalibration; ++i)
    step(i, i) = i % 3 == 0 ? 0 : 0.01 * i;  // some parameters are held
  MarginalPrior after = before;
  TakeRandomStep(step, after);
  MatrixXd expected = before.H.inverse();
  expected.bottomRightCorner<kNumCalibration, kNumCalibration>() += step;
  EXPECT_LT((after.H.inverse() - expected).norm(), 1e-9 * expected.norm());
  EXPECT_LT((MeanOf(after) - MeanOf(before)).norm(), 1e-9);
}

TEST(CalibrationWalkTest, InformationDrawsTheCalibrationToWhatWasGiven) {
  const MarginalPrior before = MakePrior();
  CalibrationMatrix information = CalibrationMatrix::Zero();
  for (int i = 0; i < kNumCalibration; ++i)
    information(i, i) = i % 3 == 0 ? 0 : 10.0 * i;
  MarginalPrior after = before;
  ASSERT_TRUE(AddInformation(information, after));
  // Kalman's update with a measurement of zero, of those parameters that it is about.
  MatrixXd H = before.H;
  H.bottomRightCorner<kNumCalibration, kNumCalibration>() += information;
  EXPECT_LT((after.H - H).norm(), 1e-9 * H.norm());
  const VectorXd expected = H.ldlt().solve(before.H * MeanOf(before));
  EXPECT_LT((MeanOf(after) - expected).norm(), 1e-9);
}

TEST(CalibrationWalkTest, APriorThatDoesNotKnowTheCalibrationStays) {
  MarginalPrior prior;
  prior.blocks = {MarginalPrior::Block::OfPose(FrameId{1}, 0)};
  prior.H = MatrixXd::Identity(kPose, kPose);
  prior.b = VectorXd::Ones(kPose);
  EXPECT_FALSE(TakeRandomStep(CalibrationMatrix::Identity(), prior));
  EXPECT_FALSE(AddInformation(CalibrationMatrix::Identity(), prior));
  EXPECT_EQ(prior.H, MatrixXd(MatrixXd::Identity(kPose, kPose)));
  EXPECT_EQ(prior.b, VectorXd(VectorXd::Ones(kPose)));
}

}  // namespace
}  // namespace facet
