// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/factors/imu_factor.h"

#include <cmath>

#include <gtest/gtest.h>

#include "facet/geometry/so3.h"
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
    const Vector3d scale = 0.02 * rng.Normal3();
    const ImuResidual linear = LinearizeImu(imu, i, j, scale);
    EXPECT_EQ(linear.r, ImuError(imu, i, j, scale));
    testing::ExpectJacobian<15, 15>(
        linear.J_i,
        [&](const Vector<15>& d) { return ImuError(imu, testing::Retract(i, d), j, scale); },
        1e-8,
        1e-5);
    testing::ExpectJacobian<15, 15>(
        linear.J_j,
        [&](const Vector<15>& d) { return ImuError(imu, i, testing::Retract(j, d), scale); },
        1e-8,
        1e-5);
    // The derivative by the scale is that of angles without noise.
    NavState at_measured = j;
    at_measured.T_WB.q = imu.Predict(i).T_WB.q;
    testing::ExpectJacobian<15, 3>(
        LinearizeImu(imu, i, at_measured, scale).J_scale,
        [&](const Vector3d& d) { return ImuError(imu, i, at_measured, scale + d); },
        1e-8,
        1e-5);
  }
}

// Against the dense products.
TEST(ImuFactorTest, SquaresAreThoseOfAllRows) {
  Rng rng(8);
  const ImuPreintegration imu = RandomInterval(0.3, rng);
  const Matrix<15, 15> sqrt_info = ImuSqrtInfo(imu, testing::DefaultBiasWalk());
  const NavState i = RandomState(rng), j = RandomState(rng);
  const ImuResidual linear = LinearizeImu(imu, i, j, Vector3d(0.01, 0.02, -0.01));
  const Vector<15> r = sqrt_info * linear.r;
  Matrix<15, 30> J;
  J << sqrt_info * linear.J_i, sqrt_info * linear.J_j;
  const ImuSquares squares = Square(sqrt_info, linear, r);
  const Matrix<30, 30> H = J.transpose() * J;
  const Vector<30> b = J.transpose() * r;
  EXPECT_LT((squares.H - H).norm(), 1e-12 * H.norm());
  EXPECT_LT((squares.b - b).norm(), 1e-12 * b.norm());
  EXPECT_LT((squares.J - J.topRows<9>()).norm(), 1e-12 * J.norm());
}

// What a gyroscope measures while it does not turn is noise: it says nothing of the scale.
TEST(ImuFactorTest, NoiseOfTheAnglesIsNoDerivativeByTheScale) {
  const Vector3d noise(0.01, -0.02, 0.03);
  ImuPreintegration at_rest({}, {});
  std::vector<ImuSample> samples;
  for (int k = 0; k <= 20; ++k)
    samples.push_back({Timestamp{k * 5'000'000LL}, noise, Vector3d(0, 0, kGravity)});
  at_rest.Integrate(samples);
  const NavState i;
  NavState j = at_rest.Predict(i);
  const double measured = LinearizeImu(at_rest, i, j, Vector3d::Zero()).J_scale.topRows<3>().norm();
  j.T_WB.q = i.T_WB.q;
  EXPECT_NEAR(measured, 0.1 * noise.norm(), 1e-5);
  EXPECT_LT(LinearizeImu(at_rest, i, j, Vector3d::Zero()).J_scale.topRows<3>().norm(),
            2e-3 * measured);
}

// In errors that are large beside what a scale factor of the sensor explains.
TEST(ImuFactorTest, ErrorSigmaOfManyIsManySigmas) {
  Rng rng(3);
  const ImuPreintegration imu = RandomInterval(0.2, rng);
  const ImuLink link{imu, ImuSqrtInfo(imu, testing::DefaultBiasWalk())};
  const NavState i = RandomState(rng);
  EXPECT_LT(ImuErrorSigma(link, i, imu.Predict(i), imu.gyro_scale()), 1e-6);
  double sum = 0;
  constexpr int kRuns = 200;
  constexpr double kSigmas = 100;
  for (int run = 0; run < kRuns; ++run) {
    Vector<15> noise;
    for (int k = 0; k < 15; ++k)
      noise[k] = rng.Normal();
    const Vector<15> step = kSigmas * (link.sqrt_info.inverse() * noise);
    sum += ImuErrorSigma(link, i, testing::Retract(imu.Predict(i), step), imu.gyro_scale());
  }
  // The larger one of two RMS of few values, that of the rotation 1.5 times.
  EXPECT_NEAR(sum / kRuns / kSigmas, 1.4, 0.15);
  NavState broken = imu.Predict(i);
  broken.v_WB.x() = std::nan("");
  EXPECT_TRUE(std::isinf(ImuErrorSigma(link, i, broken, imu.gyro_scale())));
}

TEST(ImuFactorTest, PositionErrorOfTheAssumedNoiseIsOneInTheMeanSquare) {
  Rng rng(7);
  const ImuPreintegration imu = RandomInterval(0.2, rng);
  const ImuLink link{imu, ImuSqrtInfo(imu, testing::DefaultBiasWalk())};
  const NavState i = RandomState(rng);
  const auto error_at = [&](const Vector<15>& step) {
    return ImuPositionError(link, i, testing::Retract(imu.Predict(i), step), imu.gyro_scale());
  };
  EXPECT_LT(error_at(Vector<15>::Zero()), 1e-9);
  double sum = 0;
  constexpr int kRuns = 1000;
  for (int run = 0; run < kRuns; ++run) {
    Vector<15> noise;
    for (int k = 0; k < 15; ++k)
      noise[k] = rng.Normal();
    sum += error_at(link.sqrt_info.inverse() * noise);
  }
  EXPECT_NEAR(sum / kRuns, 1, 0.1);
  EXPECT_FALSE(std::isfinite(error_at(Vector<15>::Constant(std::nan("")))));
}

TEST(ImuFactorTest, AScaleFactorOfTheSensorIsNoError) {
  Rng rng(4);
  for (int run = 0; run < 20; ++run) {
    const ImuPreintegration imu = RandomInterval(0.2, rng);
    const ImuLink link{imu, ImuSqrtInfo(imu, testing::DefaultBiasWalk())};
    const NavState i = RandomState(rng);
    const auto turned_by = [&](double share) {
      NavState j = imu.Predict(i);
      j.T_WB.q = j.T_WB.q * ExpSO3(share * LogSO3(imu.dR()));
      j.v_WB += share * (i.T_WB.q * imu.dv());
      j.T_WB.p += share * (i.T_WB.q * imu.dp());
      return j;
    };
    EXPECT_LT(ImuErrorSigma(link, i, turned_by(0.0029), imu.gyro_scale()), 1e-3);
    EXPECT_GT(ImuErrorSigma(link, i, turned_by(0.05), imu.gyro_scale()), 4);
  }
}

TEST(ImuFactorTest, ResidualVanishesAtThePrediction) {
  Rng rng(2);
  for (int run = 0; run < 50; ++run) {
    const ImuPreintegration imu = RandomInterval(0.3, rng);
    const NavState i = RandomState(rng);
    EXPECT_LT(ImuError(imu, i, imu.Predict(i), imu.gyro_scale()).norm(), 1e-13);
  }
}

// What a sensor that reads too much says fits a state that moves less, once its scale is known.
TEST(ImuFactorTest, TheScaleExplainsASensorThatReadsTooMuch) {
  Rng rng(5);
  const Vector3d scale(0.01, -0.02, 0.015);
  const testing::TestMotion motion = testing::TestMotion::Random(rng);
  ImuPreintegration right, wrong;
  std::vector<ImuSample> samples;
  for (int i = 0; i <= 60; ++i)
    samples.push_back(motion.ImuAt(i / 200.0, {}));
  right.Integrate(samples);
  for (ImuSample& sample : samples)
    sample.gyro = sample.gyro.cwiseQuotient(Vector3d::Ones() - scale);
  wrong.Integrate(samples);
  const NavState i = RandomState(rng), j = right.Predict(i);
  const Vector<15> unexplained = ImuError(wrong, i, j, Vector3d::Zero());
  EXPECT_GT(unexplained.head<3>().norm(), 1e-3);
  const Vector<15> first_order = ImuError(wrong, i, j, scale);
  EXPECT_LT(first_order.head<3>().norm(), 0.03 * unexplained.head<3>().norm());
  wrong.Reintegrate({}, scale);
  EXPECT_LT(ImuError(wrong, i, j, wrong.gyro_scale()).norm(), 1e-12);
}

TEST(ImuFactorTest, ResidualIsPredictedMinusMeasured) {
  Rng rng(3);
  const ImuPreintegration imu = RandomInterval(0.3, rng);
  const NavState i = RandomState(rng);
  const Matrix3d R_BiW = i.T_WB.R().transpose();
  const Vector<15> step = testing::RandomStep({0.2, 0.3, 0.4, 0.05, 0.1}, rng);
  const Vector<15> r = ImuError(imu, i, testing::Retract(imu.Predict(i), step), imu.gyro_scale());
  EXPECT_LT((r.segment<3>(0) - step.segment<3>(0)).norm(), 1e-13);
  EXPECT_LT((r.segment<3>(3) - R_BiW * step.segment<3>(3)).norm(), 1e-13);
  EXPECT_LT((r.segment<3>(6) - R_BiW * step.segment<3>(6)).norm(), 1e-13);
  EXPECT_LT((r.tail<6>() - step.tail<6>()).norm(), 1e-13);
}

}  // namespace
}  // namespace facet
