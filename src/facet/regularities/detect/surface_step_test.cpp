// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/detect/surface_step.h"

#include <vector>

#include <gtest/gtest.h>

#include "facet/base/random.h"

namespace facet {
namespace {

// A level surface of 4 x 2 m that rises by `step_m` where x > 0.3.
std::vector<Vector3d> PointsWithStep(double step_m, double sigma_m, int num_points, Rng& rng) {
  std::vector<Vector3d> points;
  for (int i = 0; i < num_points; ++i) {
    const double x = rng.Uniform(-2, 2), y = rng.Uniform(-1, 1);
    points.emplace_back(x, y, (x > 0.3 ? step_m : 0) + sigma_m * rng.Normal());
  }
  return points;
}

std::optional<SurfaceStep> Find(const std::vector<Vector3d>& points, double length_scale = 1) {
  const std::vector<double> weights(points.size(), 1 / (0.02 * 0.02));
  return FindStep(points, weights, FitPlane(points, weights), length_scale);
}

TEST(SurfaceStepTest, FindsAStepAndWhereItIs) {
  Rng rng(1);
  for (int run = 0; run < 100; ++run) {
    const auto step = Find(PointsWithStep(0.1, 0.02, 80, rng));
    ASSERT_TRUE(step) << run;
    EXPECT_GT(std::abs(step->direction_W.x()), 0.97);
    const double sign = step->direction_W.x() > 0 ? 1 : -1;
    EXPECT_NEAR(sign * step->position_m, 0.3, 0.3);
    EXPECT_NE(step->IsBeyond({1.5, 0, 0}), step->IsBeyond({-1, 0, 0}));
  }
}

// What a tight gate leaves of both sides when the plane leans across the step: its residuals add up
// to nothing on each side.
TEST(SurfaceStepTest, FindsAStepInWhatAGateLeft) {
  Rng rng(4);
  const Plane bridge{Vector3d(-0.05, 0, 1).normalized(), 0.05};
  for (int run = 0; run < 100; ++run) {
    std::vector<Vector3d> points = PointsWithStep(0.1, 0.01, 160, rng);
    std::erase_if(points, [&](const auto& p) { return std::abs(bridge.SignedDistance(p)) > 0.03; });
    EXPECT_TRUE(Find(points)) << run;
  }
}

TEST(SurfaceStepTest, OnePlaneHasNone) {
  Rng rng(2);
  for (int run = 0; run < 1000; ++run) {
    const double sigma_m = 0.01 * (1 + run % 5);
    EXPECT_FALSE(Find(PointsWithStep(0, sigma_m, 20 + 10 * (run % 20), rng))) << run;
  }
}

TEST(SurfaceStepTest, SmallStepsAndFewPointsAreNone) {
  Rng rng(3);
  EXPECT_FALSE(Find(PointsWithStep(0.015, 0.001, 200, rng)));
  EXPECT_FALSE(Find(PointsWithStep(0.1, 0.001, 15, rng)));
  EXPECT_FALSE(Find(PointsWithStep(0.1, 0.001, 1, rng)));
  EXPECT_TRUE(Find(PointsWithStep(0.1, 0.001, 200, rng), 3));  // far away: 9 cm
  EXPECT_FALSE(Find(PointsWithStep(0.07, 0.001, 200, rng), 3));
}

}  // namespace
}  // namespace facet
