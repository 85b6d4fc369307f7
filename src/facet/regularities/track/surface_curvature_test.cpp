// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/track/surface_curvature.h"

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/geometry/so3.h"

namespace facet {
namespace {

constexpr double kSigma_m = 0.01;

// Points of the surface z = height(x, y) over 2 x 2 m, far from the origin and turned.
template <class Height>
std::optional<SurfaceCurvature> BendOf(Height height, int num, double noise_m, std::uint64_t seed) {
  Rng rng(seed);
  const Quaterniond q_WS = ExpSO3({0.7, -0.4, 0.2});
  std::vector<Vector3d> points_W;
  for (int i = 0; i < num; ++i) {
    const double x = rng.Uniform(-1, 1), y = rng.Uniform(-1, 1);
    const double z = height(x, y) + noise_m * rng.Normal();
    points_W.push_back(q_WS * Vector3d(x, y, z) + Vector3d(40, -20, 3));
  }
  const std::vector<double> weights(points_W.size(), 1 / (kSigma_m * kSigma_m));
  return FitCurvature(points_W, weights, q_WS * Vector3d::UnitZ());
}

const auto kFlat = [](double, double) { return 0.0; };

TEST(SurfaceCurvatureTest, NoiseHasThreeDegreesOfFreedom) {
  double sum = 0;
  constexpr int kRuns = 2000;
  for (int run = 0; run < kRuns; ++run)
    sum += BendOf(kFlat, 20, kSigma_m, static_cast<std::uint64_t>(run))->chi_square / kRuns;
  EXPECT_NEAR(sum, 3, 0.2);
}

TEST(SurfaceCurvatureTest, APlaneThatLeansIsNotBent) {
  const auto leaning = [](double x, double y) { return 0.1 + 0.05 * x - 0.02 * y; };
  const auto bend = BendOf(leaning, 20, 0, 1);
  ASSERT_TRUE(bend);
  EXPECT_NEAR(bend->chi_square, 0, 1e-6);
  EXPECT_LT(bend->size_m, 1e-5);
}

// x^2 has the mean 1/3 and the variance 4/45 over the square.
TEST(SurfaceCurvatureTest, TheSizeIsThatOfTheSurface) {
  const auto bowl = [](double x, double) { return 0.05 * x * x; };
  const auto bend = BendOf(bowl, 5000, 0, 1);
  ASSERT_TRUE(bend);
  const double rms_m = 0.05 * std::sqrt(4.0 / 45);
  EXPECT_NEAR(bend->size_m, rms_m, 0.02 * rms_m);
  EXPECT_NEAR(bend->chi_square, 5000 * std::pow(rms_m / kSigma_m, 2), 0.05 * bend->chi_square);
}

TEST(SurfaceCurvatureTest, BothLimitsHaveToBePassed) {
  EXPECT_TRUE(IsCurved({5, 0.007}));
  EXPECT_FALSE(IsCurved({5, 0.005}));
  EXPECT_FALSE(IsCurved({3, 0.007}));
}

TEST(SurfaceCurvatureTest, WhatIsOfNoUseSaysNothing) {
  EXPECT_FALSE(BendOf(kFlat, 9, 0, 1));
  EXPECT_TRUE(BendOf(kFlat, 10, kSigma_m, 1));
  const std::vector<double> weights(12, 1.0);
  std::vector<Vector3d> line;
  for (int i = 0; i < 12; ++i)
    line.emplace_back(i, 0, 0);
  EXPECT_FALSE(FitCurvature(line, weights, Vector3d::UnitZ()));
  line[3].setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_FALSE(FitCurvature(line, weights, Vector3d::UnitZ()));
}

}  // namespace
}  // namespace facet
