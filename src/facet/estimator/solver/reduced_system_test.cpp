// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/solver/reduced_system.h"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "facet/estimator/solver/covariance.h"
#include "facet/testing/estimator/balanced_prior.h"

namespace facet {
namespace {

using testing::TestWindow;

// A disturbed window with one of the two priors, the balanced one if the seed is even.
TestWindow MakeDisturbedWindow(std::uint64_t seed, int num_planes, bool has_calibration) {
  TestWindow test = testing::MakeOptimumWindow(seed, num_planes);
  Rng rng(seed);
  if (has_calibration) testing::AddCalibration(test, rng);
  if (seed % 2 == 0) {
    testing::AddBalancedPrior(test, rng, testing::kOptimumNoise);
  } else {
    test.window.start_prior.emplace(FrameId{0}, test.truth[0].T_WB, StartOptions{});
  }
  testing::Disturb(test.window, {1e-3, 0.01, 0.01, 1e-3, 1e-3}, rng);
  return test;
}

// As a marginalisation leaves it: all of the calibration goes with the motion of the oldest frame.
void AddPriorOnMotionAndCalibration(TestWindow& test, Rng& rng) {
  constexpr int kMotion = 9, kSize = kMotion + kNumCalibration;
  Vector<kSize> inverse_sigma, direction;
  inverse_sigma << Vector<kMotion>::Constant(10),
      test.window.calibration->start_information->diagonal().cwiseSqrt();
  for (double& d : direction)
    d = 0.2 * rng.Normal();
  MarginalPrior& prior = test.window.prior;
  prior.blocks = {MarginalPrior::Block::OfMotion(FrameId{0}, 0),
                  MarginalPrior::Block::OfCalibration(kMotion)};
  prior.H = inverse_sigma.asDiagonal() *
            MatrixXd(MatrixXd::Identity(kSize, kSize) + direction * direction.transpose()) *
            inverse_sigma.asDiagonal();
  prior.b = inverse_sigma.cwiseProduct(direction);
}

// The system in which motions and landmarks are eliminated against the dense one.
TEST(ReducedSystemTest, StepAndCovarianceEqualTheDenseSystem) {
  for (std::uint64_t seed = 51; seed < 60; ++seed) {
    TestWindow test = MakeDisturbedWindow(seed, seed % 2 == 0 ? 2 : 0, seed > 55);
    Rng rng(seed);
    if (seed == 57 || seed == 59) AddPriorOnMotionAndCalibration(test, rng);
    const NormalEquations dense = testing::Assemble(test.window, test.rig, testing::kOptimumWidth);
    const VectorXd s = dense.H.diagonal().cwiseSqrt().cwiseInverse();
    const MatrixXd scaled = s.asDiagonal() * dense.H * s.asDiagonal();
    const MatrixXd inverse = s.asDiagonal() * scaled.inverse() * s.asDiagonal();
    LinearizedWindow linear;
    ReducedSystem reduced;
    testing::Linearize(test, testing::kOptimumNoise, linear);
    ASSERT_TRUE(reduced.Solve(0.0, linear));
    const VectorXd step = -inverse * dense.b;
    EXPECT_LT((reduced.step() - step).norm(), 1e-6 * step.norm());
    const std::size_t newest = test.window.frames.size() - 1;
    std::vector<int> columns;
    for (int k = 0; k < 6; ++k)
      columns.push_back(dense.layout.pose_column[newest] + k);
    for (int k = 0; k < 9; ++k)
      columns.push_back(dense.layout.motion_column[newest] + k);
    const Matrix<15, 15> expected = inverse(columns, columns);
    const Vector<15> scale = expected.diagonal().cwiseSqrt().cwiseInverse();
    const Matrix<15, 15> error = NewestFrameCovariance(reduced, linear.layout()) - expected;
    EXPECT_LT((scale.asDiagonal() * error * scale.asDiagonal()).cwiseAbs().maxCoeff(), 1e-6);
  }
}

// A calibration that is held stays in the residuals and leaves the equations.
TEST(ReducedSystemTest, WithAHeldCalibrationTheRestIsSolvedForWhereItIs) {
  for (std::uint64_t seed = 61; seed < 65; ++seed) {
    TestWindow test = MakeDisturbedWindow(seed, 0, true);
    test.window.calibration->SetDelta(CalibrationVector::Constant(1e-4));
    const NormalEquations dense = testing::Assemble(test.window, test.rig, testing::kOptimumWidth);
    std::vector<int> others;
    for (int c = 0; c < dense.layout.dim; ++c) {
      const int of_calibration = c - dense.layout.calibration_column;
      if (of_calibration < 0 || of_calibration >= kNumCalibration) others.push_back(c);
    }
    const MatrixXd H = dense.H(others, others);
    const VectorXd b = dense.b(others);
    const VectorXd s = H.diagonal().cwiseSqrt().cwiseInverse();
    const VectorXd step =
        -s.cwiseProduct((s.asDiagonal() * H * s.asDiagonal()).inverse() * s.cwiseProduct(b));
    LinearizedWindow linear;
    ReducedSystem reduced;
    testing::Linearize(test, testing::kOptimumNoise, linear, CalibrationStep::kHeld);
    ASSERT_EQ(linear.layout().dim, static_cast<int>(others.size()));
    ASSERT_TRUE(reduced.Solve(0.0, linear));
    const auto in_sigmas = [&](const VectorXd& x) { return s.cwiseInverse().cwiseProduct(x); };
    EXPECT_LT(in_sigmas(reduced.step() - step).norm(), 1e-6 * in_sigmas(step).norm());
  }
}

}  // namespace
}  // namespace facet
