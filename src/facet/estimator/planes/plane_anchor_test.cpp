// SPDX-License-Identifier: BSD-2-Clause
// A plane with another anchor is the same plane, and what the prior knows of it is the same.
#include "facet/estimator/planes/plane_anchor.h"

#include <cmath>
#include <vector>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "facet/estimator/factors/prior_factor.h"
#include "facet/estimator/solver/marginalization.h"
#include "facet/geometry/so3.h"
#include "facet/testing/estimator/test_gauge.h"
#include "facet/testing/estimator/test_window.h"

namespace facet {
namespace {

using testing::TestWindow;

// Two planes on which every other landmark lies, known to a prior and moved since.
TestWindow MakeWindow(std::uint64_t seed) {
  Rng rng(seed);
  testing::TestWindowOptions options;
  options.num_landmarks = 80;
  TestWindow test = testing::MakeTestWindow(options, rng);
  test.window.start_prior.emplace(FrameId{0}, test.truth[0].T_WB, StartOptions{});
  for (int k = 0; k < 2; ++k) {
    const Vector3d n = rng.UnitVector();
    test.window.planes.emplace_back(PlaneId{k},
                                    Plane{n, n.dot(test.points[0])},
                                    Vector3d(test.points[0] + rng.Normal3()),
                                    testing::kPlaneSigma_m);
  }
  for (std::size_t l = 0; l < test.window.landmarks().size(); ++l)
    test.window.landmarks()[l].planes.Add(static_cast<int>(l % 2));
  MarginalizationPlan plan(test.window);
  plan.drop_frame[0] = 1;
  for (std::size_t l = 0; l < plan.drop_landmark.size(); l += 3)
    plan.drop_landmark[l] = 1;
  Marginalize(plan, test.rig, FactorNoise(EstimatorOptions{}), test.window);
  for (WindowPlane& plane : test.window.planes) {
    EXPECT_TRUE(plane.frozen);
    plane.ApplyStep(0.02 * rng.Normal3());
  }
  EXPECT_GT(PriorDelta(test.window).norm(), 0);
  return test;
}

double PriorCost(const SlidingWindow& window) {
  return PriorFactor(window).Cost();
}

// What the new variables are of the old: only the offset's column differs, equation (7.5).
MatrixXd ChangeOfVariables(const SlidingWindow& window, int plane, const Vector3d& shift_W) {
  const StateLayout layout = MakeLayout(window);
  MatrixXd T = MatrixXd::Identity(layout.dim, layout.dim);
  const int column = layout.plane_column[static_cast<std::size_t>(plane)];
  T.block<1, 2>(column + 2, column) =
      -shift_W.transpose() * TangentBasis(window.planes[plane].n_lin);
  return T;
}

TEST(PlaneAnchorTest, TheSurfaceStays) {
  TestWindow test = MakeWindow(1);
  const WindowPlane before = test.window.planes[1];
  MoveAnchor(before.anchor_W + Vector3d(3, -4, 5), 1, test.window);
  const WindowPlane& after = test.window.planes[1];
  EXPECT_EQ(after.n, before.n);
  EXPECT_EQ(after.n_lin, before.n_lin);
  EXPECT_NEAR(after.plane().d, before.plane().d, 1e-12);
  EXPECT_NEAR(after.SignedDistance({1, 2, 3}), before.SignedDistance({1, 2, 3}), 1e-12);
  EXPECT_GT(std::abs(after.offset - before.offset), 1e-3);
}

TEST(PlaneAnchorTest, CostGradientAndHessianOfThePriorStay) {
  for (std::uint64_t seed = 2; seed < 7; ++seed) {
    TestWindow test = MakeWindow(seed);
    Rng rng(seed);
    SlidingWindow before = test.window;
    const Vector3d shift = 5 * rng.Normal3();
    MoveAnchor(before.planes[0].anchor_W + shift, 0, test.window);
    EXPECT_NEAR(PriorCost(test.window), PriorCost(before), 1e-9 * std::abs(PriorCost(before)));

    NormalEquations old_prior, new_prior;
    old_prior.Clear(before);
    new_prior.Clear(test.window);
    PriorFactor(before).AddTo(old_prior);
    PriorFactor(test.window).AddTo(new_prior);
    const auto& [layout, H, b] = old_prior;
    const MatrixXd& H_new = new_prior.H;
    const VectorXd& b_new = new_prior.b;
    const MatrixXd T = ChangeOfVariables(before, 0, shift);
    const VectorXd s = H.diagonal().cwiseMax(1).cwiseSqrt().cwiseInverse();
    const MatrixXd error = T.transpose() * H_new * T - H;
    EXPECT_LT((s.asDiagonal() * error * s.asDiagonal()).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_LT(s.cwiseProduct(T.transpose() * b_new - b).norm(), 1e-9 * s.cwiseProduct(b).norm());

    // And after a step, the same one in both variables.
    const VectorXd step = 0.01 * VectorXd::Random(layout.dim);
    const auto apply = [&](SlidingWindow& window, const VectorXd& d) {
      for (std::size_t k = 0; k < window.planes.size(); ++k)
        window.planes[k].ApplyStep(d.segment<3>(old_prior.layout.plane_column[k]));
    };
    apply(before, step);
    apply(test.window, T * step);
    EXPECT_NEAR(PriorCost(test.window), PriorCost(before), 1e-9 * std::abs(PriorCost(before)));
  }
}

TEST(PlaneAnchorTest, TheWholeSystemStays) {
  TestWindow test = MakeWindow(8);
  const SlidingWindow before = test.window;
  const Vector3d shift(2, 3, -1);
  MoveAnchor(before.planes[1].anchor_W + shift, 1, test.window);
  const NormalEquations a = testing::Assemble(before, test.rig, 2.0);
  const NormalEquations b = testing::Assemble(test.window, test.rig, 2.0);
  const MatrixXd T = ChangeOfVariables(before, 1, shift);
  const VectorXd s = a.H.diagonal().cwiseMax(1).cwiseSqrt().cwiseInverse();
  const MatrixXd error = T.transpose() * b.H * T - a.H;
  EXPECT_LT((s.asDiagonal() * error * s.asDiagonal()).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT(s.cwiseProduct(T.transpose() * b.b - a.b).norm(), 1e-9 * s.cwiseProduct(a.b).norm());
  // Gauge directions go over into gauge directions.
  const Vector3d pivot(1, 2, 3);
  EXPECT_LT(
      (T * testing::WindowDirections(before, pivot) - testing::WindowDirections(test.window, pivot))
          .norm(),
      1e-11);
}

TEST(PlaneAnchorTest, APlaneThatIsNotFrozenMovesToo) {
  TestWindow test = MakeWindow(9);
  const Vector3d n = Vector3d(1, 2, 3).normalized();
  test.window.planes.emplace_back(
      PlaneId{5}, Plane{n, 2}, Vector3d::Zero(), testing::kPlaneSigma_m);
  const MatrixXd H = test.window.prior.H;
  MoveAnchor({3, 3, 3}, 2, test.window);
  EXPECT_EQ(test.window.prior.H, H);
  EXPECT_NEAR(test.window.planes[2].plane().d, 2, 1e-12);
  EXPECT_EQ(test.window.planes[2].delta.norm(), 0);
}

TEST(PlaneAnchorTest, AnchorsFollowTheLandmarks) {
  TestWindow test = MakeWindow(10);
  EXPECT_EQ(FollowLandmarks(1e3, test.window), 0);
  EXPECT_EQ(FollowLandmarks(0.0, test.window), 2);
  for (int k = 0; k < 2; ++k) {
    Vector3d sum = Vector3d::Zero();
    int count = 0;
    for (const WindowLandmark& landmark : test.window.landmarks()) {
      if (!landmark.planes.Contains(k)) continue;
      sum += test.window.PositionOf(landmark);
      ++count;
    }
    EXPECT_LT((test.window.planes[static_cast<std::size_t>(k)].anchor_W - sum / count).norm(),
              1e-9);
  }
  EXPECT_EQ(FollowLandmarks(1e-6, test.window), 0);
  // Without landmarks a plane keeps its anchor.
  for (WindowLandmark& landmark : test.window.landmarks())
    landmark.planes = PlaneLinks();
  EXPECT_EQ(FollowLandmarks(0.0, test.window), 0);
}

// Covariance of a plane's own three numbers by the prior.
Matrix3d CovarianceByThePrior(const SlidingWindow& window, PlaneId plane) {
  const MatrixXd covariance = window.prior.H.inverse();
  for (const MarginalPrior::Block& block : window.prior.blocks) {
    if (block.kind == Variable::Kind::kPlane && block.plane == plane)
      return covariance.block<3, 3>(block.offset, block.offset);
  }
  ADD_FAILURE() << "the prior does not know the plane";
  return {};
}

// Against the same move on a flat surface: normal and offset are known less by the unevenness, once
// for each time that the landmarks' spread fits into the way.
TEST(PlaneAnchorTest, OfAnUnevenSurfaceAnotherPieceIsKnownLess) {
  TestWindow flat = MakeWindow(11);
  TestWindow uneven = MakeWindow(11);
  constexpr double kUnevenness_m = 0.03;
  uneven.window.planes[0].unevenness_m = kUnevenness_m;
  Vector3d sum = Vector3d::Zero();
  std::vector<Vector3d> points;
  for (const WindowLandmark& landmark : flat.window.landmarks()) {
    if (landmark.planes.Contains(0)) points.push_back(flat.window.PositionOf(landmark));
  }
  for (const Vector3d& p : points)
    sum += p;
  const Vector3d mean = sum / static_cast<double>(points.size());
  double square = 0;
  for (const Vector3d& p : points)
    square += (p - mean).squaredNorm();
  const double spread_m = std::sqrt(square / static_cast<double>(points.size()));
  for (TestWindow* test : {&flat, &uneven}) {
    test->window.prior.H.diagonal().array() +=
        1;  // what the gauge leaves open has a covariance, too
    MoveAnchor(mean + 2 * spread_m * Vector3d::UnitX(), 0, test->window);
  }
  ASSERT_EQ(FollowLandmarks(1.5 * spread_m, flat.window), FollowLandmarks(10, uneven.window));

  const Matrix3d added = CovarianceByThePrior(uneven.window, PlaneId{0}) -
                         CovarianceByThePrior(flat.window, PlaneId{0});
  const double slope = kUnevenness_m / spread_m;
  const Matrix3d expected =
      2 * Vector3d(slope * slope, slope * slope, kUnevenness_m * kUnevenness_m).asDiagonal();
  EXPECT_LT((added - expected).norm(), 0.02 * expected.norm());
  EXPECT_LT((CovarianceByThePrior(uneven.window, PlaneId{1}) -
             CovarianceByThePrior(flat.window, PlaneId{1}))
                .norm(),
            0.05 * expected.norm());
}

}  // namespace
}  // namespace facet
