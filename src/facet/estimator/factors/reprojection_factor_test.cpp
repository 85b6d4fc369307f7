// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/factors/reprojection_factor.h"

#include <cmath>

#include <gtest/gtest.h>

#include "facet/estimator/factors/robust_loss.h"
#include "facet/testing/estimator/test_landmark.h"

namespace facet {
namespace {

using testing::Derivative;
using testing::GeometryOf;
using testing::kWidth;
using testing::Linearized;
using testing::MakeProblem;
using testing::Measurement;
using testing::Moved;
using testing::Problem;
using testing::Problems;
using testing::RelativeError;
using testing::WorldPoint;

// The rows of one measurement: J of the pose of its frame, J of the landmark (two directions in its
// host, inverse distance). The host stays where it is when the pose of a frame is moved.
struct Rows {
  Vector2d r;
  MatrixXd J_pose, J_landmark;
};
Rows NumericRows(const Problem& problem, const Measurement& m) {
  const SE3& T_WB = problem.poses[m.frame];
  const WorldPoint point = problem.FromHost(problem.host(), Vector3d::Zero());
  const auto moved_pose = [&](const VectorXd& d) -> VectorXd {
    return problem.Residual(m, Moved(T_WB, d), point);
  };
  const auto moved_landmark = [&](const VectorXd& d) -> VectorXd {
    return problem.Residual(m, T_WB, problem.FromHost(problem.host(), d));
  };
  const double w = problem.RootWeight(m);
  return {w * problem.Residual(m, T_WB, point),
          w * Derivative(moved_pose, 6),
          w * Derivative(moved_landmark, 3)};
}

TEST(ReprojectionFactorTest, BlocksAreTheGaussNewtonBlocksOfTheWorldParameters) {
  for (const Problem& problem : Problems(1)) {
    const LandmarkBlock block = Linearized(problem);
    ASSERT_EQ(block.num_views, static_cast<int>(problem.landmark.observations.size()));
    Matrix3d V = Matrix3d::Zero();
    Vector3d b = Vector3d::Zero();
    for (int v = 0; v < block.num_views; ++v) {
      Matrix<6, 6> H_view = Matrix<6, 6>::Zero();
      Matrix<6, 3> W_view = Matrix<6, 3>::Zero();
      Vector<6> b_view = Vector<6>::Zero();
      for (const Measurement& m : problem.measurements) {
        if (m.frame != block.views[v].frame) continue;
        const Rows rows = NumericRows(problem, m);
        H_view += rows.J_pose.transpose() * rows.J_pose;
        W_view += rows.J_pose.transpose() * rows.J_landmark;
        b_view += rows.J_pose.transpose() * rows.r;
        V += rows.J_landmark.transpose() * rows.J_landmark;
        b += rows.J_landmark.transpose() * rows.r;
      }
      EXPECT_LT(RelativeError(block.pose_squares[v].H, H_view), 1e-8);
      EXPECT_LT(RelativeError(block.views[v].W, W_view), 1e-8);
      EXPECT_LT(RelativeError(block.pose_squares[v].b, b_view), 1e-8);
    }
    EXPECT_LT(RelativeError(block.V, V), 1e-8);
    EXPECT_LT(RelativeError(block.b, b), 1e-8);
  }
}

TEST(ReprojectionFactorTest, GradientIsThatOfTheRobustCost) {
  for (const Problem& problem : Problems(2)) {
    const LandmarkBlock block = Linearized(problem);
    const WorldPoint point = problem.FromHost(problem.host(), Vector3d::Zero());
    EXPECT_NEAR(block.cost, problem.Cost(problem.poses, point), 1e-9 * (1 + block.cost));
    EXPECT_DOUBLE_EQ(
        block.cost,
        LandmarkCost(GeometryOf(problem), {}, problem.landmark, testing::NoiseOfWidth(kWidth)));
    constexpr double kStep = 1e-7;
    for (int k = 0; k < 3; ++k) {
      const Vector3d e = kStep * Vector3d::Unit(k);
      const double numeric = (problem.Cost(problem.poses, problem.FromHost(problem.host(), e)) -
                              problem.Cost(problem.poses, problem.FromHost(problem.host(), -e))) /
                             (2 * kStep);
      EXPECT_NEAR(block.b(k), numeric, 1e-5 * (1 + block.b.norm()));
    }
    for (int v = 0; v < block.num_views; ++v) {
      for (int k = 0; k < 6; ++k) {
        std::vector<SE3> plus = problem.poses, minus = problem.poses;
        const Vector<6> e = kStep * Vector<6>::Unit(k);
        plus[block.views[v].frame] = Moved(problem.poses[block.views[v].frame], e);
        minus[block.views[v].frame] = Moved(problem.poses[block.views[v].frame], -e);
        const double numeric =
            (problem.Cost(plus, point) - problem.Cost(minus, point)) / (2 * kStep);
        EXPECT_NEAR(
            block.pose_squares[v].b(k), numeric, 1e-5 * (1 + block.pose_squares[v].b.norm()));
      }
    }
  }
}

TEST(ReprojectionFactorTest, APointBehindACameraHasNoRowsAndABoundedCost) {
  Rng rng(6);
  Problem problem = MakeProblem({false, false, 0.0}, rng);
  // The last observing frame turns its back on the point.
  const int frame = problem.landmark.observations.back().frame;
  ASSERT_NE(frame, problem.landmark.observations.front().frame);
  problem.landmark.host = problem.landmark.observations.front().frame;
  const Vector3d p_H = problem.Camera(problem.host(), 0).Inverse() *
                       (problem.Camera(problem.poses[0], 0) * Vector3d(0.1, 0.1, 3));
  problem.landmark.bearing_H = p_H.normalized();
  problem.landmark.inverse_distance = 1 / p_H.norm();
  const Vector3d y_axis_B = problem.rig.T_BC[0].q * Vector3d::UnitY();
  problem.poses[frame] = problem.poses[frame].Retract(M_PI * y_axis_B, Vector3d::Zero());
  const FrameGeometry geometry = GeometryOf(problem);
  const WindowObservation& last = problem.landmark.observations.back();
  EXPECT_FALSE(ReprojectionError(geometry, problem.landmark, last, 0));
  const LandmarkBlock block = Linearized(problem);
  const LandmarkBlock::View& view = block.views[block.num_views - 1];
  const LandmarkBlock::PoseSquare& square = block.pose_squares[block.num_views - 1];
  EXPECT_EQ(square.H.norm() + square.b.norm() + view.W.norm(), 0);
  EXPECT_TRUE(std::isfinite(block.cost));
  EXPECT_DOUBLE_EQ(block.cost,
                   LandmarkCost(geometry, {}, problem.landmark, testing::NoiseOfWidth(kWidth)));
  WindowLandmark without = problem.landmark;
  without.observations.pop_back();
  // 30 sigma under the robust loss.
  EXPECT_NEAR(block.cost - LandmarkCost(geometry, {}, without, testing::NoiseOfWidth(kWidth)),
              GemanMcClureLoss(30, kWidth).cost,
              1e-9);
}

TEST(ReprojectionFactorTest, FrozenPosesKeepTheirJacobiansAndUseTheCurrentResidual) {
  Rng rng(7);
  const Problem problem = MakeProblem({false, true, 0.3}, rng);
  std::vector<WindowFrame> frames(problem.poses.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    frames[i].x.T_WB = frames[i].lin.T_WB = problem.poses[i];
    frames[i].pose_frozen = true;
    frames[i].has_motion = false;
    frames[i].ApplyStep(testing::RandomStep({1e-4, 1e-3, 0, 0, 0}, rng));
  }
  FrameGeometry geometry(problem.rig);
  geometry.Update(frames);
  LandmarkBlock block;
  LinearizeLandmark(geometry, {}, problem.landmark, testing::NoiseOfWidth(1e9), block);
  LandmarkBlock at_lin;
  LinearizeLandmark(GeometryOf(problem), {}, problem.landmark, testing::NoiseOfWidth(1e9), at_lin);
  EXPECT_EQ(block.V, at_lin.V);
  Problem moved = problem;
  for (std::size_t i = 0; i < frames.size(); ++i)
    moved.poses[i] = frames[i].x.T_WB;
  EXPECT_NEAR(block.cost,
              LandmarkCost(GeometryOf(moved), {}, problem.landmark, testing::NoiseOfWidth(1e9)),
              1e-9);
  EXPECT_GT(std::abs(block.cost - at_lin.cost), 1e-3);
}

}  // namespace
}  // namespace facet
