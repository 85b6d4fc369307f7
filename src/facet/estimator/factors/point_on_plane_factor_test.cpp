// SPDX-License-Identifier: BSD-2-Clause
// The row that ties a landmark to a plane, against numeric derivatives and closed forms.
#include <gtest/gtest.h>

#include "facet/testing/estimator/test_landmark.h"
#include "facet/testing/numeric_jacobian.h"

namespace facet {
namespace {

using testing::Derivative;
using testing::GeometryOf;
using testing::kWidth;
using testing::Problem;
using testing::RelativeError;
using testing::WorldPoint;

constexpr double kSigma_m = 0.01;

// A plane that passes `distance` from the landmark, with its anchor somewhere else.
WindowPlane PlaneNear(const Problem& problem, double distance, Rng& rng) {
  const WorldPoint point = problem.FromHost(problem.host(), Vector3d::Zero());
  const Vector3d l_W = point.y / point.rho;
  const Vector3d n = rng.UnitVector();
  const Vector3d anchor = l_W + rng.Normal3();
  return {PlaneId{0}, Plane{n, n.dot(l_W) - distance}, anchor, kSigma_m};
}

double Distance(const Problem& problem, WindowPlane plane, const VectorXd& d) {
  plane.ApplyStep(d.head<3>());
  const WorldPoint point = problem.FromHost(problem.host(), d.tail<3>());
  return plane.SignedDistance(point.y / point.rho);
}

TEST(PointOnPlaneFactorTest, BlocksAreTheGaussNewtonBlocksOfPlaneAndLandmark) {
  Rng rng(3);
  for (const double distance : {0.004, 0.2}) {  // within Huber's limit, and beyond
    for (int run = 0; run < 10; ++run) {
      Problem problem = testing::MakeProblem({false, true, 1.0}, rng);
      FactorNoise noise = testing::NoiseOfWidth(kWidth);
      noise.plane_huber_sigma = 2.0;
      const WindowPlane plane = PlaneNear(problem, distance, rng);
      LandmarkBlock without, with;
      LinearizeLandmark(GeometryOf(problem), {plane}, problem.landmark, noise, without);
      problem.landmark.planes.Add(0);
      LinearizeLandmark(GeometryOf(problem), {plane}, problem.landmark, noise, with);
      ASSERT_EQ(with.num_plane_views, 1);
      EXPECT_EQ(without.num_plane_views, 0);

      const double s = distance / kSigma_m;
      const double w = s <= 2 ? 1 : std::sqrt(2 / s);
      const MatrixXd J = w / kSigma_m *
                         Derivative(
                             [&](const VectorXd& d) -> VectorXd {
                               return VectorXd::Constant(1, Distance(problem, plane, d));
                             },
                             6);
      const Matrix<1, 3> J_plane = J.leftCols<3>(), J_landmark = J.rightCols<3>();
      const LandmarkBlock::PlaneView& view = with.plane_views[0];
      EXPECT_LT(RelativeError(view.J_plane, J_plane.transpose()), 1e-7);
      EXPECT_LT(RelativeError(view.J_landmark, J_landmark.transpose()), 1e-7);
      EXPECT_NEAR(view.residual, w * s, 1e-7 * w * s);
      EXPECT_LT(RelativeError(with.V - without.V, J_landmark.transpose() * J_landmark), 1e-6);
      EXPECT_LT((with.b - without.b - w * s * J_landmark.transpose()).norm(), 1e-6 * with.b.norm());
      const double cost = s <= 2 ? 0.5 * s * s : 2 * (s - 1);
      EXPECT_NEAR(with.cost - without.cost, cost, 1e-6 * (1 + cost));
      EXPECT_NEAR(LandmarkCost(GeometryOf(problem), {plane}, problem.landmark, noise),
                  with.cost,
                  1e-9 * with.cost);
    }
  }
}

TEST(PointOnPlaneFactorTest, AFrozenPlaneKeepsItsJacobianAndUsesTheCurrentResidual) {
  Rng rng(4);
  Problem problem = testing::MakeProblem({false, true, 0.5}, rng);
  problem.landmark.planes.Add(0);
  FactorNoise noise = testing::NoiseOfWidth(kWidth);
  noise.plane_huber_sigma = 1e9;
  WindowPlane plane = PlaneNear(problem, 0.003, rng);
  LandmarkBlock before, after;
  LinearizeLandmark(GeometryOf(problem), {plane}, problem.landmark, noise, before);
  plane.Freeze();
  plane.ApplyStep(Vector3d(2e-3, -1e-3, 5e-3));
  LinearizeLandmark(GeometryOf(problem), {plane}, problem.landmark, noise, after);
  EXPECT_EQ(before.plane_views[0].J_plane, after.plane_views[0].J_plane);
  EXPECT_EQ(before.V, after.V);
  const WorldPoint point = problem.FromHost(problem.host(), Vector3d::Zero());
  EXPECT_NEAR(
      after.plane_views[0].residual, plane.SignedDistance(point.y / point.rho) / kSigma_m, 1e-9);
  EXPECT_GT(std::abs(after.plane_views[0].residual - before.plane_views[0].residual), 0.1);
}

TEST(PointOnPlaneFactorTest, StepsAddUpOnAFrozenPlane) {
  Rng rng(5);
  WindowPlane plane(PlaneId{1}, Plane{rng.UnitVector(), 2.0}, Vector3d(1, 2, 3), kSigma_m);
  EXPECT_NEAR(plane.plane().d, 2.0, 1e-12);
  plane.Freeze();
  WindowPlane twice = plane;
  plane.ApplyStep(Vector3d(0.1, -0.05, 0.2));
  twice.ApplyStep(Vector3d(0.06, -0.03, 0.1));
  twice.ApplyStep(Vector3d(0.04, -0.02, 0.1));
  EXPECT_LT((plane.n - twice.n).norm(), 1e-12);
  EXPECT_NEAR(plane.offset, twice.offset, 1e-12);
  EXPECT_NEAR(plane.n.norm(), 1, 1e-12);
  EXPECT_LT((plane.delta - twice.delta).norm(), 1e-12);
}

TEST(PointOnPlaneFactorTest, APointNearInfinityIsNotTiedToAnything) {
  Rng rng(6);
  Problem problem = testing::MakeProblem({true, true, 0.5}, rng);
  problem.landmark.planes.Add(0);
  const WindowPlane plane(PlaneId{0}, Plane{Vector3d::UnitZ(), 0}, Vector3d::Zero(), kSigma_m);
  LandmarkBlock block;
  LinearizeLandmark(
      GeometryOf(problem), {plane}, problem.landmark, testing::NoiseOfWidth(kWidth), block);
  EXPECT_EQ(block.num_plane_views, 0);
  EXPECT_TRUE(block.V.allFinite());
}

}  // namespace
}  // namespace facet
