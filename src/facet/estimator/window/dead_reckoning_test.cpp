// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/window/dead_reckoning.h"

#include <cmath>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/testing/estimator/test_window.h"

namespace facet {
namespace {

using testing::TestMotion;

constexpr double kRate = 200;

std::vector<ImuSample> Samples(const TestMotion& motion,
                               double t0,
                               double t1,
                               const ImuBias& bias) {
  std::vector<ImuSample> samples;
  const int n = static_cast<int>(std::lround((t1 - t0) * kRate));
  for (int i = 0; i <= n; ++i)
    samples.push_back(motion.ImuAt(t0 + i / kRate, bias));
  return samples;
}

// A cloud of states around the first one, with noisy samples, ends as a cloud with the covariance
// that is stated, and around the state that is stated.
TEST(DeadReckoningTest, AgreesWithMonteCarlo) {
  Rng rng(5);
  const TestMotion motion = TestMotion::Random(rng);
  const ImuBias bias{{0.01, -0.02, 0.03}, {0.1, 0.2, -0.1}};
  const std::vector<ImuSample> samples = Samples(motion, 0, 1, bias);
  ImuParameters noise;
  noise.gyro = 2e-3;
  noise.accel = 2e-2;
  const BiasWalk walk = testing::DefaultBiasWalk();
  ImuPreintegration measured(bias, noise);
  measured.Integrate(samples);
  ReckonedState from;
  from.x = motion.At(0);
  from.x.bias = bias;
  Vector<15> sigma;
  sigma << Vector3d::Constant(0.01), Vector3d::Constant(0.02), Vector3d::Constant(0.03),
      Vector3d::Constant(2e-3), Vector3d::Constant(2e-2);
  from.covariance = sigma.cwiseAbs2().asDiagonal();
  const ReckonedState to = Reckon(from, measured, walk);
  EXPECT_LT((to.x.T_WB.p - motion.At(1).T_WB.p).norm(), 1e-3);

  constexpr int kRuns = 3000;
  double nees = 0;
  const Eigen::LLT<Matrix<15, 15>> llt(to.covariance);
  ASSERT_EQ(llt.info(), Eigen::Success);
  for (int run = 0; run < kRuns; ++run) {
    Vector<15> step;
    for (int i = 0; i < 15; ++i)
      step[i] = sigma[i] * rng.Normal();
    WindowFrame start;
    start.x = from.x;
    start.ApplyStep(step);
    std::vector<ImuSample> noisy = samples;
    for (ImuSample& s : noisy) {
      s.gyro += noise.gyro * std::sqrt(kRate) * rng.Normal3();
      s.accel += noise.accel * std::sqrt(kRate) * rng.Normal3();
    }
    ImuPreintegration seen(start.x.bias, noise);
    seen.Integrate(noisy);
    NavState end = seen.Predict(start.x);
    const double root_T = std::sqrt(seen.dt());
    end.bias.b_g += walk.gyro * root_T * rng.Normal3();
    end.bias.b_a += walk.accel * root_T * rng.Normal3();
    nees += llt.matrixL().solve(testing::Difference(to.x, end)).squaredNorm() / kRuns;
  }
  // The standard error is 0.1; what is beyond is the second order.
  EXPECT_NEAR(nees, 15, 0.6);
}

TEST(DeadReckoningTest, TwoIntervalsAreAsGoodAsOne) {
  Rng rng(6);
  const TestMotion motion = TestMotion::Random(rng);
  const BiasWalk walk = testing::DefaultBiasWalk();
  ReckonedState from;
  from.x = motion.At(0);
  from.covariance = 1e-4 * Matrix<15, 15>::Identity();
  const auto integrate = [&](double t0, double t1) {
    ImuPreintegration measured;
    measured.Integrate(Samples(motion, t0, t1, {}));
    return measured;
  };
  const ReckonedState once = Reckon(from, integrate(0, 1), walk);
  const ReckonedState twice =
      Reckon(Reckon(from, integrate(0, 0.5), walk), integrate(0.5, 1), walk);
  EXPECT_LT((once.x.T_WB.p - twice.x.T_WB.p).norm(), 1e-9);
  EXPECT_LT((once.covariance - twice.covariance).norm(), 1e-3 * once.covariance.norm());
}

}  // namespace
}  // namespace facet
