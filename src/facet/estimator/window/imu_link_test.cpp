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
  options.max_gyro_noise = 1;
  options.max_accel_noise = 2;
  EXPECT_EQ(ParametersInUse(noise, options).gyro, 10);
  EXPECT_EQ(ParametersInUse(noise, options).accel, 40);
  options.gravity_mps2 = 3.71;
  EXPECT_EQ(ParametersInUse(noise, options).gravity, 3.71);
  EXPECT_EQ(BiasWalk(noise, options).gyro, 90);
  EXPECT_EQ(BiasWalk(noise, options).accel, 160);
}

TEST(ImuLinkTest, InflatedDensitiesAreNotInflatedAgain) {
  ImuNoise noise;
  const ImuOptions options;
  EXPECT_TRUE(InflationWarnings(noise, options).empty()) << "as of EuRoC's IMU";
  const ImuParameters usual = ParametersInUse(noise, options);
  EXPECT_EQ(usual.gyro, noise.gyro_noise * options.gyro_noise_scale);
  EXPECT_EQ(usual.accel, noise.accel_noise * options.accel_noise_scale);

  noise.gyro_noise *= 10;
  noise.accel_noise *= 10;
  const ImuParameters capped = ParametersInUse(noise, options);
  EXPECT_EQ(capped.gyro, options.max_gyro_noise * options.gyro_noise_scale);
  EXPECT_EQ(capped.accel, options.max_accel_noise * options.accel_noise_scale);
  EXPECT_LT(capped.gyro, 3 * usual.gyro);
  EXPECT_LT(capped.accel, 3 * usual.accel);
  const std::vector<std::string> warnings = InflationWarnings(noise, options);
  ASSERT_EQ(warnings.size(), 2u);
  EXPECT_NE(warnings[0].find("'gyroscope_noise_density' is 0.0017"), std::string::npos);
  EXPECT_NE(warnings[1].find("estimator.imu.max_accel_noise=0.02 takes"), std::string::npos);
}

}  // namespace
}  // namespace facet
