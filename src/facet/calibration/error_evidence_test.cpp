// SPDX-License-Identifier: BSD-2-Clause
// Against Gaussians that are written out, and calibrations of which is known how they are wrong.
#include "facet/calibration/error_evidence.h"

#include <cmath>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "facet/base/random.h"

namespace facet {
namespace {

CalibrationMatrix RandomCovariance(double sigma, Rng& rng) {
  Matrix<kNumCalibration, 2 * kNumCalibration> A;
  for (double& a : A.reshaped())
    a = sigma * rng.Normal() / std::sqrt(2.0 * kNumCalibration);
  return A * A.transpose();
}

CalibrationVector Drawn(const CalibrationMatrix& covariance, Rng& rng) {
  CalibrationVector v;
  for (double& x : v)
    x = rng.Normal();
  return covariance.llt().matrixL() * v;
}

// A belief, what is measured with this noise, and both together.
struct Case {
  Rng rng;
  CalibrationMatrix believed, noise, before, left;
  CalibrationVector error;

  Case(std::uint64_t seed, double noise_sigma, double error_size)
      : rng(seed), believed(RandomCovariance(1, rng)), noise(RandomCovariance(noise_sigma, rng)) {
    before = believed.inverse();
    left = (before + noise.inverse()).inverse();
    for (double& x : error)
      x = error_size * rng.Normal();
  }
  CalibrationVector Estimate(const CalibrationVector& measured) const {
    return left * noise.inverse() * measured;
  }
  double EvidenceFor(const CalibrationVector& measured) const {
    return JudgeError(error, before, Estimate(measured), left).evidence;
  }
};

// Twice the logarithm of a normal density, but for what all of them have in common.
double LogDensity(const CalibrationVector& m, const CalibrationMatrix& covariance) {
  const Eigen::LDLT<CalibrationMatrix> factor(covariance);
  return -m.dot(CalibrationVector(factor.solve(m))) - factor.vectorD().array().log().sum();
}

TEST(ErrorEvidenceTest, IsTheRatioOfTheDensities) {
  for (const double noise : {0.1, 1.0, 10.0}) {
    for (const double size : {0.01, 1.0, 100.0}) {
      Case c(7, noise, size);
      const CalibrationVector m = Drawn(c.believed + c.noise, c.rng);
      const CalibrationMatrix careful = c.believed + c.noise;
      const CalibrationMatrix rough = careful + c.error * c.error.transpose();
      const double expected = LogDensity(m, rough) - LogDensity(m, careful);
      EXPECT_NEAR(c.EvidenceFor(m), expected, 1e-6 * (1 + std::abs(expected))) << noise << size;
    }
  }
}

TEST(ErrorEvidenceTest, IsThereForTheErrorThatWasMade) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Case c(seed, 3, 10);
    const CalibrationVector careful = Drawn(c.believed + c.noise, c.rng);
    EXPECT_LT(c.EvidenceFor(careful), 10) << seed;
    EXPECT_GT(c.EvidenceFor(careful + c.error), 25) << seed;
    EXPECT_GT(c.EvidenceFor(careful - c.error), 25) << seed;
  }
}

TEST(ErrorEvidenceTest, NothingMeasuredIsNoEvidence) {
  Case c(3, 1, 10);
  const ErrorVerdict verdict = JudgeError(c.error, c.before, CalibrationVector::Zero(), c.believed);
  EXPECT_NEAR(verdict.evidence, 0, 1e-9);
  EXPECT_EQ(verdict.delta, CalibrationVector::Zero());
  EXPECT_LT(c.EvidenceFor(CalibrationVector::Zero()), 0) << "what was right needs no error";
  const CalibrationMatrix held = 1e-14 * CalibrationMatrix::Identity(), before = held.inverse();
  const CalibrationVector noise = 1e-9 * Drawn(CalibrationMatrix::Identity(), c.rng);
  EXPECT_EQ(JudgeError(c.error, before, noise, held).evidence, 0) << "what is held";
}

TEST(ErrorVerdictTest, HasTheMeanOfTheWiderBelief) {
  for (const double size : {0.01, 1.0, 100.0}) {
    Case c(9, 2, size);
    const CalibrationVector m = Drawn(c.believed + c.noise, c.rng) + c.error;
    const CalibrationMatrix wider = c.believed + c.error * c.error.transpose();
    const CalibrationVector expected =
        (wider.inverse() + c.noise.inverse()).inverse() * c.noise.inverse() * m;
    const CalibrationVector found = JudgeError(c.error, c.before, c.Estimate(m), c.left).delta;
    EXPECT_LT((found - expected).norm(), 1e-6 * (1 + expected.norm())) << size;
  }
}

TEST(FreeErrorsTest, AreTheEstimateAndTheDensityOfTheWiderBelief) {
  for (const double size : {0.01, 1.0, 30.0}) {
    Case c(11, 2, size);
    CalibrationVector second;
    for (double& x : second)
      x = size * c.rng.Normal();
    const std::vector<CalibrationVector> errors = {c.error, second};
    const CalibrationVector m = Drawn(c.believed + c.noise, c.rng) + c.error - 2 * second;
    CalibrationMatrix wider = c.believed;
    for (const CalibrationVector& error : errors)
      wider += error * error.transpose();
    const CalibrationMatrix left = (wider.inverse() + c.noise.inverse()).inverse();
    const CalibrationVector delta = left * c.noise.inverse() * m;
    const double evidence = LogDensity(m, wider + c.noise) - LogDensity(m, c.believed + c.noise);
    const FreedEstimate found = FreeErrors(errors, c.before, c.Estimate(m), c.left);
    EXPECT_LT((found.delta - delta).norm(), 1e-6 * (1 + delta.norm())) << size;
    EXPECT_LT((found.left - left).norm(), 1e-6 * left.norm()) << size;
    EXPECT_NEAR(found.evidence, evidence, 1e-6 * (1 + std::abs(evidence))) << size;
  }
}

// The estimate then is as if it had been believed possible from the start.
TEST(RoomForErrorTest, IsTheInformationThatIsLeftOfTheBelief) {
  for (const double size : {0.01, 1.0, 100.0}) {
    Case c(5, 1, size);
    const CalibrationMatrix wider = c.believed + c.error * c.error.transpose();
    const CalibrationMatrix room = RoomForError(c.error, c.before);
    EXPECT_LT((c.before + room - wider.inverse()).norm(), 1e-7 * c.before.norm()) << size;
    Eigen::SelfAdjointEigenSolver<CalibrationMatrix> solver(room);
    EXPECT_LT(solver.eigenvalues().maxCoeff(), 1e-9 * c.before.norm());
  }
}

}  // namespace
}  // namespace facet
