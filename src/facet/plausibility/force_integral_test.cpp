// SPDX-License-Identifier: BSD-2-Clause
// Against the preintegration, which the estimator uses.
#include "facet/plausibility/force_integral.h"

#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/imu/preintegration.h"

namespace facet {
namespace {

std::vector<ImuSample> RandomSamples(std::uint64_t seed) {
  Rng rng(seed);
  std::vector<ImuSample> samples;
  Timestamp t{1'000'000'000};
  for (int i = 0; i < 60; ++i) {
    samples.push_back({t, rng.Normal3(), Vector3d(0, 0, kGravity) + 3 * rng.Normal3()});
    t = t + Duration{4'000'000 + 50'000 * i};
  }
  return samples;
}

TEST(ForceIntegralTest, ItsAxesAddUpToThePreintegration) {
  const std::vector<ImuSample> samples = RandomSamples(3);
  const Vector3d b_g(0.02, -0.01, 0.05);
  ImuPreintegration reference({b_g, Vector3d::Zero()}, {});
  reference.Integrate(samples);
  ForceIntegral integral(b_g);
  integral.Integrate(std::span(samples).first(20));
  integral.Integrate(std::span(samples).subspan(19));
  EXPECT_NEAR(integral.dt_s(), reference.dt(), 1e-12);
  const auto& [velocity, displacement] = integral.measured();
  EXPECT_LT((velocity.rowwise().sum() - reference.dv()).norm(), 1e-12);
  EXPECT_LT((displacement.rowwise().sum() - reference.dp()).norm(), 1e-12);
  const auto& by_bias = reference.BiasJacobian();
  EXPECT_LT((integral.constant().displacement + by_bias.block<3, 3>(3, 3)).norm(), 1e-12);
  EXPECT_LT((integral.constant().velocity + by_bias.block<3, 3>(6, 3)).norm(), 1e-12);
}

TEST(ForceIntegralTest, AnAxisAloneIsItsColumn) {
  std::vector<ImuSample> samples = RandomSamples(4);
  ForceIntegral all(Vector3d::Zero()), one(Vector3d::Zero());
  all.Integrate(samples);
  for (ImuSample& sample : samples)
    sample.accel = Vector3d(0, sample.accel.y(), 0);
  one.Integrate(samples);
  EXPECT_LT((all.measured().velocity.col(1) - one.measured().velocity.rowwise().sum()).norm(),
            1e-12);
  EXPECT_LT(
      (all.measured().displacement.col(1) - one.measured().displacement.rowwise().sum()).norm(),
      1e-12);
}

}  // namespace
}  // namespace facet
