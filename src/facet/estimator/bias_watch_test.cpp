// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/bias_watch.h"

#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/base/random.h"

namespace facet {
namespace {

using ::testing::HasSubstr;

/// Five keyframes per second; the biases are functions of the time in seconds.
struct Flight {
  std::function<ImuBias(double)> bias_at;
  double sigma_b_g = 2e-4, sigma_b_a = 0.02;
  double duration_s = 40;
};

/// The first drift, and when.
struct Found {
  std::optional<BiasDrift> drift;
  double at_s = 0;
};

Found Fly(const Flight& flight, BiasWatch& watch) {
  for (double t = 0; t < flight.duration_s; t += 0.2) {
    BiasEvidence evidence;
    evidence.t = Timestamp{} + FromSeconds(t);
    evidence.bias = flight.bias_at(t);
    evidence.sigma_b_g.setConstant(flight.sigma_b_g);
    evidence.sigma_b_a.setConstant(flight.sigma_b_a);
    const auto drift = watch.Add(evidence);
    if (drift) return {drift, t};
  }
  return {};
}

Found Fly(const Flight& flight) {
  BiasWatch watch{ImuNoise()};
  return Fly(flight, watch);
}

TEST(BiasWatchTest, SaysNothingOfABiasThatWalksAsItsNoiseSays) {
  const ImuNoise noise;
  Rng rng(1);
  ImuBias bias;
  const Found found = Fly({[&](double) {
                             for (int axis = 0; axis < 3; ++axis) {
                               bias.b_g(axis) += noise.gyro_walk * std::sqrt(0.2) * rng.Normal();
                               bias.b_a(axis) += noise.accel_walk * std::sqrt(0.2) * rng.Normal();
                             }
                             return bias;
                           },
                           1e-5,
                           1e-3,
                           600});
  EXPECT_FALSE(found.drift);
}

TEST(BiasWatchTest, NamesAnAccelerometerThatCreeps) {
  const Found found = Fly({[](double t) {
    ImuBias bias;
    bias.b_a.y() = t < 10 ? 0 : -0.04 * (t - 10);
    return bias;
  }});
  ASSERT_TRUE(found.drift);
  EXPECT_FALSE(found.drift->is_gyro);
  EXPECT_EQ(found.drift->axis, 1);
  EXPECT_LT(found.drift->change, 0);
  EXPECT_GT(found.at_s, 11);
  EXPECT_LT(found.at_s, 20);
  EXPECT_THAT(InWords(*found.drift), HasSubstr("accelerometer's bias along y changed by -0.1"));
}

TEST(BiasWatchTest, NamesAGyroscopeThatJumps) {
  const Found found = Fly({[](double t) {
    ImuBias bias;
    bias.b_g.z() = t < 10 ? 0 : 0.004;
    return bias;
  }});
  ASSERT_TRUE(found.drift);
  EXPECT_TRUE(found.drift->is_gyro);
  EXPECT_EQ(found.drift->axis, 2);
  EXPECT_NEAR(found.at_s, 10, 0.3);
  EXPECT_THAT(InWords(*found.drift), HasSubstr("gyroscope's bias along z"));
}

// A bias that was not known yet may change by what was not known of it; another life has another.
TEST(BiasWatchTest, LearningABiasIsNoDrift) {
  BiasWatch watch{ImuNoise()};
  BiasEvidence evidence;
  evidence.sigma_b_a.setConstant(0.2);
  evidence.sigma_b_g.setConstant(0.01);
  EXPECT_FALSE(watch.Add(evidence));
  evidence.t = evidence.t + FromSeconds(4);
  evidence.bias.b_a.x() = 0.5;
  evidence.sigma_b_a.setConstant(0.01);
  EXPECT_FALSE(watch.Add(evidence));
  watch.Break();
  evidence.t = evidence.t + FromSeconds(4);
  evidence.bias.b_a.x() = -5;
  EXPECT_FALSE(watch.Add(evidence));
}

}  // namespace
}  // namespace facet
