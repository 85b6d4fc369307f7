// SPDX-License-Identifier: BSD-2-Clause
#include "facet/geometry/plane_fit.h"

#include <vector>

#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/geometry/so3.h"

namespace facet {
namespace {

TEST(PlaneFitTest, FindsAPlaneAndHowPointsSpreadOverIt) {
  Rng rng(1);
  for (int run = 0; run < 20; ++run) {
    const Plane truth{rng.UnitVector(), rng.Uniform(-5, 5)};
    const Matrix<3, 2> B = TangentBasis(truth.n);
    std::vector<Vector3d> points;
    // Uniform on a rectangle of 4 x 1 m: deviations of 4 / sqrt(12) and 1 / sqrt(12).
    for (int i = 0; i < 4000; ++i) {
      const Vector2d in_plane(rng.Uniform(-2, 2), rng.Uniform(-0.5, 0.5));
      points.push_back(truth.d * truth.n + B * in_plane + 0.01 * rng.Normal() * truth.n);
    }
    const PlaneFit fit = FitPlane(points);
    EXPECT_GT(std::abs(fit.plane.n.dot(truth.n)), std::cos(0.005));
    EXPECT_NEAR(std::abs(fit.plane.d), std::abs(truth.d), 0.01);
    EXPECT_NEAR(fit.plane.SignedDistance(fit.centroid), 0, 1e-12);
    EXPECT_NEAR(fit.extent_major_m, 4 / std::sqrt(12.0), 0.04);
    EXPECT_NEAR(fit.extent_minor_m, 1 / std::sqrt(12.0), 0.01);
    EXPECT_NEAR(fit.thickness_m, 0.01, 0.001);
  }
}

TEST(PlaneFitTest, WeightsDecide) {
  const std::vector<Vector3d> points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0.5, 0.5, 9}};
  const std::vector<double> weights = {1, 1, 1, 1, 1e-12};
  const PlaneFit fit = FitPlane(points, weights);
  EXPECT_NEAR(std::abs(fit.plane.n.z()), 1, 1e-9);
  EXPECT_NEAR(fit.centroid.z(), 0, 1e-9);
}

TEST(PlaneFitTest, CollinearPointsHaveNoNarrowExtent) {
  const std::vector<Vector3d> line = {{0, 0, 0}, {1, 1, 0}, {2, 2, 0}, {5, 5, 0}};
  EXPECT_NEAR(FitPlane(line).extent_minor_m, 0, 1e-6);
  EXPECT_NEAR(FitPlane(std::vector<Vector3d>{{1, 2, 3}}).extent_major_m, 0, 1e-12);
}

TEST(PlaneTest, RetractedDirectionsStayUnitAndMoveByTheAngle) {
  Rng rng(2);
  for (int run = 0; run < 100; ++run) {
    const Vector3d n = rng.UnitVector();
    const Vector2d u(rng.Normal(), rng.Normal());
    const Vector3d moved = RetractDirection(n, 0.3 * u);
    EXPECT_NEAR(moved.norm(), 1, 1e-12);
    EXPECT_NEAR(std::acos(moved.dot(n)), 0.3 * u.norm(), 1e-9);
    EXPECT_LT((RetractDirection(n, 1e-14 * u) - n).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace facet
