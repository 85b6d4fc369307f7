// SPDX-License-Identifier: BSD-2-Clause
// Groups of parameters that were calibrated with more or less care, measured by made-up
// measurements.
#include "facet/calibration/believed_share.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "facet/base/median.h"
#include "facet/base/random.h"

namespace facet {
namespace {

constexpr int kSize = 20;

VectorXd Normal(int size, Rng& rng) {
  VectorXd v(size);
  for (double& x : v)
    x = rng.Normal();
  return v;
}

// Correlated, in units that are five orders of magnitude apart.
MatrixXd FirstCovariance() {
  Rng rng(5);
  MatrixXd A(kSize, 2 * kSize);
  for (double& a : A.reshaped())
    a = rng.Normal();
  VectorXd units(kSize);
  for (int i = 0; i < kSize; ++i)
    units(i) = std::pow(10.0, 5.0 * i / kSize - 3);
  return units.asDiagonal() * A * A.transpose() * units.asDiagonal();
}

// Deviations with `true_share` of the first covariance are measured with noise of `noise_share` of
// it, and estimated with a prior of `share`.
GroupEstimate Measure(double true_share, double noise_share, double share, Rng& rng) {
  const MatrixXd first = FirstCovariance();
  const MatrixXd root = first.llt().matrixL();
  const VectorXd truth = std::sqrt(true_share) * (root * Normal(kSize, rng));
  const VectorXd measured = truth + std::sqrt(noise_share) * (root * Normal(kSize, rng));
  const double gain = share / (share + noise_share);
  return {gain * measured, gain * noise_share * first, share};
}

double MedianShare(double true_share, double noise_share, double share) {
  Rng rng(11);
  std::vector<double> found;
  for (int run = 0; run < 101; ++run)
    found.push_back(BelievedShare(FirstCovariance(), Measure(true_share, noise_share, share, rng)));
  return *Median(found);
}

TEST(BelievedShareTest, WithoutAMeasurementItIsAsGivenByNineToOne) {
  const MatrixXd first = FirstCovariance();
  const double share = BelievedShare(first, {VectorXd::Zero(kSize), first, 1});
  EXPECT_GT(share, 0.9);
  EXPECT_LT(share, 0.95);
}

TEST(BelievedShareTest, ExactParametersAreBelievedOnceTheyAreMeasured) {
  EXPECT_LT(MedianShare(0, 0.1, 1), 0.05);
  EXPECT_LT(MedianShare(0, 0.01, 1), 0.015);
}

TEST(BelievedShareTest, ParametersThatAreAsWrongAsBelievedStayFree) {
  Rng rng(3);
  double sum = 0, least = 1;
  constexpr int kRuns = 300;
  for (int run = 0; run < kRuns; ++run) {
    const double share = BelievedShare(FirstCovariance(), Measure(1, 0.1, 1, rng));
    sum += share / kRuns;
    least = std::min(least, share);
  }
  EXPECT_GT(sum, 0.97);
  EXPECT_GT(least, 0.25);
}

TEST(BelievedShareTest, WhatIsBetweenIsFound) {
  EXPECT_NEAR(std::log10(MedianShare(0.1, 0.01, 1)), -1, 0.15);
}

TEST(BelievedShareTest, ItDoesNotMatterWhatWasBelievedMeanwhile) {
  Rng rng_before(8), rng_after(8);
  const GroupEstimate before = Measure(0.1, 0.05, 1, rng_before);
  const GroupEstimate after = Measure(0.1, 0.05, 0.03, rng_after);
  EXPECT_NEAR(
      BelievedShare(FirstCovariance(), before), BelievedShare(FirstCovariance(), after), 1e-6);
}

TEST(BelievedShareTest, ParametersThatAreWorseThanBelievedHaveAllTheirRoom) {
  EXPECT_NEAR(MedianShare(25, 0.1, 1), 1, 1e-6);
  EXPECT_NEAR(MedianShare(25, 0.1, 0.01), 1, 1e-6);
}

TEST(BelievedShareTest, WhatIsNoCovarianceChangesNothing) {
  const MatrixXd first = FirstCovariance();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(BelievedShare(-first, {VectorXd::Zero(kSize), first, 0.3}), 0.3);
  EXPECT_EQ(BelievedShare(first, {VectorXd::Zero(kSize), -first, 0.3}), 0.3);
  EXPECT_EQ(BelievedShare(first, {VectorXd::Constant(kSize, nan), first, 0.3}), 0.3);
  EXPECT_EQ(BelievedShare(first, {VectorXd::Zero(kSize), nan * first, 0.3}), 0.3);
}

}  // namespace
}  // namespace facet
