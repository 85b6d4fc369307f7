// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/window/imu_link.h"

#include <cmath>

#include <gtest/gtest.h>

#include "facet/testing/estimator/test_window.h"

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

TEST(ImuLinkTest, SqrtInfoIsTheInverseOfTheCovariance) {
  Rng rng(4);
  const BiasWalk walk = testing::DefaultBiasWalk();
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

TEST(ImuLinkTest, SqrtInfoOfAnEmptyIntervalIsFinite) {
  EXPECT_TRUE(ImuSqrtInfo(ImuPreintegration(), testing::DefaultBiasWalk()).allFinite());
}

TEST(ImuLinkTest, NoiseAndWalkAreThoseOfTheCalibrationTimesTheOptions) {
  ImuNoise noise;
  noise.gyro_noise = 1;
  noise.accel_noise = 2;
  noise.gyro_walk = 3;
  noise.accel_walk = 4;
  ImuOptions options;
  options.gyro_noise_scale = 10;
  options.accel_noise_scale = 20;
  options.gyro_walk_scale = 30;
  options.accel_walk_scale = 40;
  EXPECT_EQ(InflatedNoise(noise, options).gyro, 10);
  EXPECT_EQ(InflatedNoise(noise, options).accel, 40);
  EXPECT_EQ(BiasWalk(noise, options).gyro, 90);
  EXPECT_EQ(BiasWalk(noise, options).accel, 160);
}

}  // namespace
}  // namespace facet
