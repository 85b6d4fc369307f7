// SPDX-License-Identifier: BSD-2-Clause
// The rows of relations against numeric derivatives; that they know nothing of the gauge.
#include "facet/estimator/factors/relation_factor.h"

#include <gtest/gtest.h>

#include "facet/geometry/so3.h"
#include "facet/testing/estimator/test_gauge.h"
#include "facet/testing/estimator/test_window.h"
#include "facet/testing/numeric_jacobian.h"

namespace facet {
namespace {

using enum PlaneRelationKind;
using testing::TestWindow;

constexpr PlaneRelationKind kAllKinds[] = {kParallel,
                                           kOrthogonal,
                                           kCoplanar,
                                           kHorizontal,
                                           kVertical,
                                           kHeadingParallel,
                                           kHeadingOrthogonal};
// Without a loss.
const RelationNoise kLinear = [] {
  RelationNoise noise{RelationOptions{}};
  noise.sigma_rad = 0.01;
  noise.gravity_sigma_rad = 0.02;
  noise.sigma_m = 0.05;
  noise.huber_sigma = 1e9;
  return noise;
}();

RelationFactor FactorOf(const SlidingWindow& window, const RelationNoise& noise = kLinear) {
  return {window, window.relations[0], noise};
}

// Normals that nearly satisfy a relation of this kind, `error` radians off.
std::pair<Vector3d, Vector3d> Normals(PlaneRelationKind kind, double error, Rng& rng) {
  const double heading = rng.Uniform(-3, 3);
  Vector3d a = ExpSO3({0, 0, heading}) * Vector3d(1, 0, rng.Uniform(-0.5, 0.5)).normalized();
  Vector3d b = (rng.Uniform() < 0.5 ? -1 : 1) * a;
  if (kind == kHorizontal) a = (rng.Uniform() < 0.5 ? 1 : -1) * Vector3d::UnitZ();
  if (kind == kVertical) a = ExpSO3({0, 0, heading}) * Vector3d::UnitX();
  if (kind == kOrthogonal) b = a.cross(rng.UnitVector()).normalized();
  if (kind == kHeadingOrthogonal)
    b = ExpSO3({0, 0, heading}) * Vector3d(0, 1, rng.Uniform(-0.5, 0.5)).normalized();
  return {ExpSO3(error * rng.Normal3()) * a, ExpSO3(error * rng.Normal3()) * b};
}

// Two planes and a relation of theirs, everything frozen and then moved a little: estimate and
// point of linearisation differ by `moved`.
TestWindow MakeWindow(PlaneRelationKind kind, double error, double moved, Rng& rng) {
  testing::TestWindowOptions options;
  options.num_frames = 3;
  options.num_landmarks = 5;
  TestWindow test = testing::MakeTestWindow(options, rng);
  SlidingWindow& window = test.window;
  const auto [n_a, n_b] = Normals(kind, error, rng);
  const Vector3d a_W = 3 * rng.Normal3(), b_W = 3 * rng.Normal3();
  window.planes.emplace_back(
      PlaneId{4}, Plane{n_a, n_a.dot(a_W) + 0.1}, a_W, testing::kPlaneSigma_m);
  window.planes.emplace_back(
      PlaneId{7}, Plane{n_b, n_b.dot(b_W) - 0.1}, b_W, testing::kPlaneSigma_m);
  EXPECT_TRUE(window.AddRelation({kind, PlaneId{4}, PlaneId{7}}));
  for (WindowPlane& plane : window.planes) {
    plane.Freeze();
    plane.ApplyStep(moved * rng.Normal3());
  }
  for (WindowFrame& frame : window.frames) {
    frame.pose_frozen = true;
    frame.ApplyStep(moved * testing::RandomStep({1, 1, 1, 1, 1}, rng));
  }
  return test;
}

Vector<4> RelationErrorAfter(SlidingWindow window, const Vector<12>& step) {
  window.planes[0].ApplyStep(step.head<3>());
  window.planes[1].ApplyStep(step.segment<3>(3));
  Vector<15> frame_step = Vector<15>::Zero();
  frame_step.head<6>() = step.tail<6>();
  window.frames[window.IndexOf(window.relations[0].frame)].ApplyStep(frame_step);
  return FactorOf(window).Error();
}

TEST(RelationFactorTest, JacobiansMatchNumericDerivatives) {
  Rng rng(1);
  for (const PlaneRelationKind kind : kAllKinds) {
    SCOPED_TRACE(static_cast<int>(kind));
    for (int run = 0; run < 10; ++run) {
      const TestWindow test = MakeWindow(kind, 0.05, 0.0, rng);
      const RelationRows rows = FactorOf(test.window).Linearize();
      EXPECT_GT(rows.num_rows, 0);
      Matrix<4, 12> J;
      J << rows.J_a, rows.J_b, rows.J_frame;
      if (test.window.relations[0].relation.IsUnary()) J.middleCols<3>(3).setZero();
      testing::ExpectJacobian<4, 12>(
          J, [&](const Vector<12>& d) { return RelationErrorAfter(test.window, d); }, 1e-7);
      EXPECT_LT((rows.r - RelationErrorAfter(test.window, Vector<12>::Zero())).norm(), 1e-12);
      EXPECT_NEAR(rows.cost, 0.5 * rows.r.squaredNorm(), 1e-9 * (1 + rows.cost));
      EXPECT_EQ(rows.J_frame.norm() > 0, FactorOf(test.window).NeedsFrame());
    }
  }
}

// However far the linearisation points are from what the relation demands, and the estimate from
// them.
TEST(RelationFactorTest, RowsKnowNothingOfPositionAndHeading) {
  Rng rng(2);
  double worst = 0;
  for (const PlaneRelationKind kind : kAllKinds) {
    for (int run = 0; run < 20; ++run) {
      const TestWindow test = MakeWindow(kind, 0.3, 0.1, rng);
      const SlidingWindow& window = test.window;
      NormalEquations equations;
      equations.Clear(window);
      FactorOf(window).AddTo(equations);
      const auto& [layout, H, b] = equations;
      const MatrixXd N = testing::WindowDirections(window, 3 * rng.Normal3());
      EXPECT_LT((N.transpose() * b).norm(), 1e-10 * (1 + b.norm())) << static_cast<int>(kind);
      const double energy = (N.transpose() * H * N).diagonal().cwiseAbs().maxCoeff();
      worst = std::max(worst, energy / (1 + H.diagonal().maxCoeff()));
    }
  }
  EXPECT_LT(worst, 1e-13);
}

// The counter-test: the planes' columns alone would measure where everything is.
TEST(RelationFactorTest, WithoutTheFrameTheyWouldKnow) {
  Rng rng(10);
  for (const PlaneRelationKind kind : {kParallel, kCoplanar, kHorizontal}) {
    const TestWindow test = MakeWindow(kind, 0.02, 0.0, rng);
    const RelationRows rows = FactorOf(test.window).Linearize();
    const auto& planes = test.window.planes;
    const Matrix<4, 4> seen = rows.J_a * testing::GaugeDirections(planes[0], Vector3d::Zero()) +
                              rows.J_b * testing::GaugeDirections(planes[1], Vector3d::Zero());
    EXPECT_GT(seen.cwiseAbs().maxCoeff(), 0.1) << static_cast<int>(kind);
  }
}

TEST(RelationFactorTest, TurningAndMovingEverythingChangesNoCost) {
  Rng rng(3);
  for (const PlaneRelationKind kind : kAllKinds) {
    TestWindow test = MakeWindow(kind, 0.1, 0.0, rng);
    const double before = FactorOf(test.window).Error().norm();
    const SE3 T(ExpSO3({0, 0, 0.7}), Vector3d(3, -2, 1));
    for (WindowPlane& plane : test.window.planes) {
      const Vector3d n = T.q * plane.n;
      const Vector3d on_plane = T * Vector3d(plane.anchor_W + plane.offset * plane.n);
      plane.n = n;
      plane.offset = n.dot(on_plane - plane.anchor_W);
    }
    for (WindowFrame& frame : test.window.frames)
      frame.x.T_WB = T * frame.x.T_WB;
    EXPECT_NEAR(FactorOf(test.window).Error().norm(), before, 1e-9 * (1 + before));
  }
}

TEST(RelationFactorTest, LossLimitsTheWeight) {
  Rng rng(4);
  const TestWindow test = MakeWindow(kOrthogonal, 0.3, 0.0, rng);
  RelationNoise robust = kLinear;
  robust.huber_sigma = 2;
  const RelationRows linear = FactorOf(test.window).Linearize();
  const RelationRows rows = FactorOf(test.window, robust).Linearize();
  const double s = linear.r.norm();
  ASSERT_GT(s, 2);
  EXPECT_NEAR(rows.cost, 2 * (s - 1), 1e-12 * s);
  EXPECT_LT((rows.J_a - std::sqrt(2 / s) * linear.J_a).norm(), 1e-12 * linear.J_a.norm());
  EXPECT_NEAR(rows.r.norm(), std::sqrt(2 / s) * s, 1e-12 * s);
}

TEST(RelationFactorTest, AFloorHasNoHeading) {
  Rng rng(5);
  TestWindow test = MakeWindow(kHeadingParallel, 0.05, 0.0, rng);
  test.window.planes[1] = WindowPlane(
      PlaneId{7}, Plane{Vector3d::UnitZ(), 0}, Vector3d::Zero(), testing::kPlaneSigma_m);
  const RelationRows rows = FactorOf(test.window).Linearize();
  EXPECT_EQ(rows.num_rows, 0);
  EXPECT_EQ(rows.cost, 0);
  EXPECT_EQ(rows.J_a.norm() + rows.J_b.norm(), 0);
}

TEST(RelationFactorTest, OutliveTheirFrame) {
  Rng rng(8);
  TestWindow test = MakeWindow(kCoplanar, 0.05, 0.0, rng);
  SlidingWindow& window = test.window;
  const double before = FactorOf(window).Error().norm();
  ASSERT_EQ(window.relations[0].frame, FrameId{2});
  window.RemoveFrame(2);
  ASSERT_EQ(window.relations[0].frame, FrameId{1});
  EXPECT_NEAR(FactorOf(window).Error().norm(), before, 1e-9);
}

}  // namespace
}  // namespace facet
