// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/factors/imu_factor.h"

#include <cmath>

#include <gtest/gtest.h>

#include "facet/testing/estimator/test_window.h"
#include "facet/testing/numeric_jacobian.h"

namespace facet {
namespace {

ImuPreintegration RandomInterval(double duration_s, Rng& rng) {
  const testing::TestMotion motion = testing::TestMotion::Random(rng);
  ImuPreintegration result({0.02 * rng.Normal3(), 0.1 * rng.Normal3()}, {});
  std::vector<ImuSample> samples;
  for (int i = 0; i <= std::lround(duration_s * 200); ++i)
    samples.push_back(motion.ImuAt(i / 200.0, {}));
  result.Integrate(samples);
  return result;
}

NavState RandomState(Rng& rng) {
  return testing::Retract({}, testing::RandomStep({1.5, 3.0, 2.0, 0.05, 0.3}, rng));
}

// The end of the interval, off by up to some tenths in every component.
NavState NearPrediction(const ImuPreintegration& imu, const NavState& i, Rng& rng) {
  return testing::Retract(imu.Predict(i), testing::RandomStep({0.3, 0.2, 0.2, 0.02, 0.1}, rng));
}

TEST(ImuFactorTest, JacobiansMatchNumericDerivatives) {
  Rng rng(1);
  for (int run = 0; run < 50; ++run) {
    const ImuPreintegration imu = RandomInterval(rng.Uniform(0.05, 0.6), rng);
    const NavState i = RandomState(rng);
    const NavState j = NearPrediction(imu, i, rng);
    const ImuResidual linear = LinearizeImu(imu, i, j);
    EXPECT_EQ(linear.r, ImuError(imu, i, j));
    testing::ExpectJacobian<15, 15>(
        linear.J_i,
        [&](const Vector<15>& d) { return ImuError(imu, testing::Retract(i, d), j); },
        1e-8,
        1e-5);
    testing::ExpectJacobian<15, 15>(
        linear.J_j,
        [&](const Vector<15>& d) { return ImuError(imu, i, testing::Retract(j, d)); },
        1e-8,
        1e-5);
  }
}

TEST(ImuFactorTest, ErrorSigmaOfOneIsOneSigma) {
  Rng rng(3);
  const ImuPreintegration imu = RandomInterval(0.2, rng);
  const Matrix<15, 15> sqrt_info = ImuSqrtInfo(imu, {});
  const NavState i = RandomState(rng);
  EXPECT_LT(ImuErrorSigma(imu, sqrt_info, i, imu.Predict(i)), 1e-6);
  double sum = 0;
  constexpr int kRuns = 200;
  for (int run = 0; run < kRuns; ++run) {
    Vector<15> noise;
    for (int k = 0; k < 15; ++k)
      noise[k] = rng.Normal();
    const Vector<15> step = sqrt_info.inverse() * noise;
    sum += ImuErrorSigma(imu, sqrt_info, i, testing::Retract(imu.Predict(i), step));
  }
  // The larger one of two RMS of few values is somewhat above 1.
  EXPECT_NEAR(sum / kRuns, 1.1, 0.15);
  NavState broken = imu.Predict(i);
  broken.v_WB.x() = std::nan("");
  EXPECT_TRUE(std::isinf(ImuErrorSigma(imu, sqrt_info, i, broken)));
}

TEST(ImuFactorTest, ResidualVanishesAtThePrediction) {
  Rng rng(2);
  for (int run = 0; run < 50; ++run) {
    const ImuPreintegration imu = RandomInterval(0.3, rng);
    const NavState i = RandomState(rng);
    EXPECT_LT(ImuError(imu, i, imu.Predict(i)).norm(), 1e-13);
  }
}

TEST(ImuFactorTest, ResidualIsPredictedMinusMeasured) {
  Rng rng(3);
  const ImuPreintegration imu = RandomInterval(0.3, rng);
  const NavState i = RandomState(rng);
  const Matrix3d R_BiW = i.T_WB.R().transpose();
  const Vector<15> step = testing::RandomStep({0.2, 0.3, 0.4, 0.05, 0.1}, rng);
  const Vector<15> r = ImuError(imu, i, testing::Retract(imu.Predict(i), step));
  EXPECT_LT((r.segment<3>(0) - step.segment<3>(0)).norm(), 1e-13);
  EXPECT_LT((r.segment<3>(3) - R_BiW * step.segment<3>(3)).norm(), 1e-13);
  EXPECT_LT((r.segment<3>(6) - R_BiW * step.segment<3>(6)).norm(), 1e-13);
  EXPECT_LT((r.tail<6>() - step.tail<6>()).norm(), 1e-13);
}

TEST(ImuFactorTest, SqrtInfoIsTheInverseOfTheCovariance) {
  Rng rng(4);
  const BiasWalk walk;
  for (const double duration_s : {0.005, 0.01, 0.05, 0.2, 1.0}) {
    const ImuPreintegration imu = RandomInterval(duration_s, rng);
    Matrix<15, 15> Sigma = Matrix<15, 15>::Zero();
    Sigma.topLeftCorner<9, 9>() = imu.Covariance();
    Sigma.diagonal().segment<3>(9).setConstant(walk.gyro * walk.gyro * imu.dt());
    Sigma.diagonal().segment<3>(12).setConstant(walk.accel * walk.accel * imu.dt());
    // W^T W = Sigma^-1 is W Sigma W^T = I, which needs no inverse of an ill-conditioned matrix.
    const Matrix<15, 15> W = ImuSqrtInfo(imu, walk);
    const Matrix<15, 15> unit = W * Sigma * W.transpose();
    EXPECT_LT((unit - Matrix<15, 15>::Identity()).cwiseAbs().maxCoeff(), 1e-6) << duration_s;
  }
}

TEST(ImuFactorTest, SqrtInfoOfAnEmptyIntervalIsFinite) {
  EXPECT_TRUE(ImuSqrtInfo(ImuPreintegration(), BiasWalk{}).allFinite());
}

}  // namespace
}  // namespace facet
