// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/factors/factor_noise.h"

#include <limits>
#include <type_traits>

#include <gtest/gtest.h>

namespace facet {
namespace {

// There is no way to leave the options out.
static_assert(!std::is_default_constructible_v<FactorNoise>);
static_assert(!std::is_default_constructible_v<RelationNoise>);
static_assert(!std::is_default_constructible_v<ProjectionNoise>);
static_assert(!std::is_aggregate_v<FactorNoise>);

TEST(FactorNoiseTest, EveryValueIsTheOptions) {
  EstimatorOptions options;
  options.solver.loss_width = 1;
  options.solver.plane_sigma_m = 2;
  options.solver.plane_common_sigma_m = 3;
  options.solver.plane_huber_sigma = 4;
  options.planes.relations.sigma_deg = 5;
  options.planes.relations.gravity_sigma_deg = 6;
  options.projection.sigma_px = 9;
  options.projection.tukey_sigma = 10;
  const FactorNoise noise(options);
  EXPECT_EQ(noise.reprojection_width, 1);
  EXPECT_EQ(noise.plane_sigma_m, 2);
  EXPECT_EQ(noise.plane_common_sigma_m, 3);
  EXPECT_EQ(noise.plane_huber_sigma, 4);
  EXPECT_EQ(noise.relations.sigma_rad, 5 * kDegree);
  EXPECT_EQ(noise.relations.gravity_sigma_rad, 6 * kDegree);
  EXPECT_EQ(noise.projection.sigma_px, 9);
  EXPECT_EQ(noise.projection.tukey_sigma, 10);
}

TEST(FactorNoiseTest, TheLossIsAsWideAsTheResidualScales) {
  ResidualScale usual;
  for (int i = 0; i < 100; ++i)
    usual.Add(0.5);
  const EstimatorOptions options;
  EXPECT_NEAR(FactorNoise(options, usual).reprojection_width,
              0.5 * FactorNoise(options).reprojection_width,
              1e-6);
}

TEST(ResidualScaleTest, FollowsWithinAFewKeyframesAndStaysUseful) {
  ResidualScale usual;
  EXPECT_EQ(usual.sigma(), 1.0);
  for (int i = 0; i < 10; ++i)
    usual.Add(0.4);
  EXPECT_NEAR(usual.sigma(), 0.4, 0.1);
  for (int i = 0; i < 100; ++i)
    usual.Add(0.0);
  EXPECT_NEAR(usual.sigma(), 0.2, 1e-6);
  for (int i = 0; i < 100; ++i)
    usual.Add(std::numeric_limits<double>::infinity());
  EXPECT_NEAR(usual.sigma(), 2.0, 1e-6);
}

}  // namespace
}  // namespace facet
