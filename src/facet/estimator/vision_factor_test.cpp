// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/vision_factor.h"

#include <cmath>
#include <iostream>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "facet/estimator/test_window.h"

namespace facet {
namespace {

constexpr double kHuber = 2.0;

// A point of the world in homogeneous coordinates: X = y / rho.
struct WorldPoint {
  Vector3d y;
  double rho;
};

// One camera of one observation.
struct Measurement {
  int frame, camera;
  Vector2d xy;
  Matrix2d sqrt_info;
};

// Residuals of one landmark, written independently of the code under test.
struct Problem {
  StereoRig rig;
  std::vector<SE3> poses;
  WindowLandmark landmark;
  std::vector<Measurement> measurements;

  SE3 Camera(const SE3& T_WB, int camera) const { return T_WB * rig.T_BC[camera]; }

  Vector2d Residual(const Measurement& m, const SE3& T_WB, const WorldPoint& point) const {
    const SE3 T_WC = Camera(T_WB, m.camera);
    const Vector3d h = T_WC.q.conjugate() * (point.y - point.rho * T_WC.p);
    return m.sqrt_info * (h.head<2>() / h.z() - m.xy);
  }

  /// The point of bearing + tangent step and inverse distance + step in a host at T_WB.
  WorldPoint FromHost(const SE3& T_WB, const Vector3d& step) const {
    const SE3 T_WH = Camera(T_WB, 0);
    const Vector3d f = landmark.bearing_H + TangentBasis(landmark.bearing_H) * step.head<2>();
    const double rho = landmark.inverse_distance + step.z();
    return {T_WH.q * f + rho * T_WH.p, rho};
  }
  const SE3& host() const { return poses[landmark.host]; }

  double Cost(const std::vector<SE3>& moved, const WorldPoint& point) const {
    double cost = 0;
    for (const Measurement& m : measurements) {
      const double s = Residual(m, moved[m.frame], point).norm();
      cost += s <= kHuber ? 0.5 * s * s : kHuber * (s - 0.5 * kHuber);
    }
    return cost;
  }
  double RootWeight(const Measurement& m) const {
    const double s = Residual(m, poses[m.frame], FromHost(host(), Vector3d::Zero())).norm();
    return std::sqrt(std::min(1.0, kHuber / s));
  }
};

struct ProblemOptions {
  bool at_infinity = false;
  bool stereo = true;
  double noise = 1.0;  ///< of measurements, in sigmas
};

Problem MakeProblem(const ProblemOptions& options, Rng& rng) {
  testing::TestWindowOptions window_options;
  window_options.num_landmarks = 1;
  window_options.miss_share = 0;
  window_options.right_share = options.stereo ? 0.7 : 0;
  Problem problem;
  testing::TestWindow test;
  do {
    test = testing::MakeTestWindow(window_options, rng);
  } while (test.points.empty() || test.window.landmarks()[0].observations.size() < 4);
  problem.rig = test.rig;
  for (const NavState& x : test.truth)
    problem.poses.push_back(x.T_WB);
  problem.landmark = test.window.landmarks()[0];
  WindowLandmark& landmark = problem.landmark;
  // Any frame may be the host, also one in the middle.
  landmark.host =
      landmark.observations[rng.Index(static_cast<int>(landmark.observations.size()))].frame;
  const Vector3d p_H = problem.Camera(problem.host(), 0).Inverse() * test.points[0];
  landmark.bearing_H = p_H.normalized();
  landmark.inverse_distance = options.at_infinity ? 0 : 1 / p_H.norm();
  const WorldPoint point = problem.FromHost(problem.host(), Vector3d::Zero());
  for (WindowObservation& o : landmark.observations) {
    for (int c = 0; c < (o.has_right ? 2 : 1); ++c) {
      const SE3 T_WC = problem.Camera(problem.poses[o.frame], c);
      testing::SetMeasurement(T_WC.q.conjugate() * (point.y - point.rho * T_WC.p), c, 0.5, o);
      const double x = rng.Normal(), y = rng.Normal();
      o.xy[c] += options.noise * o.sqrt_info[c].inverse() * Vector2d(x, y);
      problem.measurements.push_back({o.frame, c, o.xy[c], o.sqrt_info[c]});
    }
  }
  return problem;
}

FrameGeometry GeometryOf(const Problem& problem) {
  std::vector<WindowFrame> frames(problem.poses.size());
  for (std::size_t i = 0; i < frames.size(); ++i)
    frames[i].x.T_WB = problem.poses[i];
  FrameGeometry geometry(problem.rig);
  geometry.Update(frames);
  return geometry;
}

LandmarkBlock Linearized(const Problem& problem) {
  LandmarkBlock block;
  LinearizeLandmark(GeometryOf(problem), problem.landmark, RobustOptions{kHuber}, block);
  return block;
}

SE3 Moved(const SE3& T_WB, const Vector<6>& d) {
  return T_WB.Retract(d.head<3>(), d.tail<3>());
}

// Derivative with a five-point stencil, good to about 1e-11 of the value.
template <class F>
MatrixXd Derivative(const F& f, int dim) {
  constexpr double kStep = 1e-3;
  MatrixXd J;
  for (int k = 0; k < dim; ++k) {
    const VectorXd e = kStep * VectorXd::Unit(dim, k);
    const VectorXd column = (8 * (f(e) - f(-e)) - (f(2 * e) - f(-2 * e))) / (12 * kStep);
    if (k == 0) J.resize(column.size(), dim);
    J.col(k) = column;
  }
  return J;
}

double RelativeError(const MatrixXd& a, const MatrixXd& b) {
  return (a - b).cwiseAbs().maxCoeff() / (1e-3 + b.cwiseAbs().maxCoeff());
}

std::vector<Problem> Problems(std::uint64_t seed) {
  Rng rng(seed);
  std::vector<Problem> problems;
  for (int run = 0; run < 5; ++run) {
    for (const bool at_infinity : {false, true}) {
      for (const bool stereo : {false, true}) {
        // Half of the rows beyond Huber's limit, or all of them within.
        for (const double noise : {0.5, 2.5})
          problems.push_back(MakeProblem({at_infinity, stereo, noise}, rng));
      }
    }
  }
  return problems;
}

TEST(VisionFactorTest, BlocksAreTheGaussNewtonBlocksOfTheWorldParameters) {
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
        const SE3& T_WB = problem.poses[m.frame];
        const WorldPoint point = problem.FromHost(problem.host(), Vector3d::Zero());
        const double w = problem.RootWeight(m);
        const Vector2d r = w * problem.Residual(m, T_WB, point);
        // The host stays where it is when the pose of a frame is moved.
        const MatrixXd J = w * Derivative(
                                   [&](const VectorXd& d) -> VectorXd {
                                     return problem.Residual(m, Moved(T_WB, d), point);
                                   },
                                   6);
        const MatrixXd J_mu =
            w * Derivative(
                    [&](const VectorXd& d) -> VectorXd {
                      return problem.Residual(m, T_WB, problem.FromHost(problem.host(), d));
                    },
                    3);
        H_view += J.transpose() * J;
        W_view += J.transpose() * J_mu;
        b_view += J.transpose() * r;
        V += J_mu.transpose() * J_mu;
        b += J_mu.transpose() * r;
      }
      EXPECT_LT(RelativeError(block.views[v].H, H_view), 1e-8);
      EXPECT_LT(RelativeError(block.views[v].W, W_view), 1e-8);
      EXPECT_LT(RelativeError(block.views[v].b, b_view), 1e-8);
    }
    EXPECT_LT(RelativeError(block.V, V), 1e-8);
    EXPECT_LT(RelativeError(block.b, b), 1e-8);
  }
}

TEST(VisionFactorTest, GradientIsThatOfTheRobustCost) {
  for (const Problem& problem : Problems(2)) {
    const LandmarkBlock block = Linearized(problem);
    const WorldPoint point = problem.FromHost(problem.host(), Vector3d::Zero());
    EXPECT_NEAR(block.cost, problem.Cost(problem.poses, point), 1e-9 * (1 + block.cost));
    EXPECT_DOUBLE_EQ(block.cost,
                     LandmarkCost(GeometryOf(problem), problem.landmark, RobustOptions{kHuber}));
    // A small step: the second derivative of Huber's cost jumps.
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
        EXPECT_NEAR(block.views[v].b(k), numeric, 1e-5 * (1 + block.views[v].b.norm()));
      }
    }
  }
}

// Normal equations of all poses with one landmark eliminated.
struct Reduced {
  MatrixXd H;
  VectorXd b;
};

// The textbook way: bearing and inverse distance in the host, columns for host and observing frame.
Reduced ReduceWithHostColumns(const Problem& problem) {
  const int n = static_cast<int>(6 * problem.poses.size());
  MatrixXd J(2 * problem.measurements.size(), n + 3);
  VectorXd r(J.rows());
  for (std::size_t k = 0; k < problem.measurements.size(); ++k) {
    const Measurement& m = problem.measurements[k];
    const auto residual = [&](const VectorXd& d) -> VectorXd {
      const auto pose = [&](int frame) {
        return Moved(problem.poses[frame], d.segment<6>(6 * frame));
      };
      return problem.Residual(
          m, pose(m.frame), problem.FromHost(pose(problem.landmark.host), d.tail<3>()));
    };
    const double w = problem.RootWeight(m);
    J.middleRows(2 * k, 2) = w * Derivative(residual, n + 3);
    r.segment<2>(2 * k) = w * residual(VectorXd::Zero(n + 3));
  }
  const MatrixXd H = J.transpose() * J;
  const VectorXd b = J.transpose() * r;
  const MatrixXd gain = H.topRightCorner(n, 3) * H.bottomRightCorner<3, 3>().inverse();
  return {H.topLeftCorner(n, n) - gain * H.topRightCorner(n, 3).transpose(),
          b.head(n) - gain * b.tail<3>()};
}

Reduced ReduceByLibrary(const Problem& problem, const LandmarkBlock& block) {
  const int n = static_cast<int>(6 * problem.poses.size());
  Reduced out{MatrixXd::Zero(n, n), VectorXd::Zero(n)};
  std::vector<int> column;
  for (int i = 0; i < n; i += 6)
    column.push_back(i);
  for (int v = 0; v < block.num_views; ++v) {
    const LandmarkBlock::View& view = block.views[v];
    out.H.block<6, 6>(column[view.frame], column[view.frame]) += view.H;
    out.b.segment<6>(column[view.frame]) += view.b;
  }
  SubtractSchur(block, column, out.H, out.b);
  out.H = MatrixXd(out.H.selfadjointView<Eigen::Lower>());
  return out;
}

// Largest difference in units of what the rows of each column weigh before the elimination.
double ScaledError(const LandmarkBlock& block, const Reduced& a, const Reduced& b) {
  VectorXd weight = VectorXd::Constant(a.b.size(), 1e30);
  for (int v = 0; v < block.num_views; ++v) {
    weight.segment<6>(6 * block.views[v].frame) =
        block.views[v].H.diagonal().cwiseMax(1.0).cwiseSqrt();
  }
  // Columns that no row touches must be zero in both.
  for (int i = 0; i < weight.size(); ++i) {
    if (weight(i) < 1e30) continue;
    EXPECT_LT(a.H.col(i).norm() + b.H.col(i).norm(), 1e-6);
  }
  const VectorXd s = weight.cwiseInverse();
  const double H_error = (s.asDiagonal() * (a.H - b.H) * s.asDiagonal()).cwiseAbs().maxCoeff();
  return std::max(H_error,
                  s.cwiseProduct(a.b - b.b).cwiseAbs().maxCoeff() / std::sqrt(2 * block.cost));
}

TEST(VisionFactorTest, ReducedSystemEqualsTheOneWithHostColumns) {
  double worst = 0;
  for (const Problem& problem : Problems(3)) {
    LandmarkBlock block = Linearized(problem);
    const Reduced expected = ReduceWithHostColumns(problem);
    Eliminate(0.0, block);
    worst = std::max(worst, ScaledError(block, ReduceByLibrary(problem, block), expected));
  }
  std::cout << "relative difference " << worst << '\n';
  EXPECT_LT(worst, 1e-8);
}

TEST(VisionFactorTest, EliminateFactorisesTheDampedBlock) {
  for (const Problem& problem : Problems(4)) {
    LandmarkBlock block = Linearized(problem);
    for (const double lambda : {0.0, 1e-3, 10.0}) {
      Eliminate(lambda, block);
      Matrix3d V = block.V;
      V.diagonal() *= 1 + lambda;
      EXPECT_LT(RelativeError(block.L * block.L.transpose(), V), 1e-12);
      EXPECT_LT(RelativeError(block.L * block.y, block.b), 1e-12);
      for (int v = 0; v < block.num_views; ++v) {
        EXPECT_LT(RelativeError(block.views[v].Y * block.L.transpose(), block.views[v].W), 1e-12);
      }
    }
  }
}

// Two frames at the same place, left camera only: nothing is known about the distance.
TEST(VisionFactorTest, WithoutParallaxRotationIsStillConstrained) {
  Rng rng(5);
  Problem problem = MakeProblem({false, false, 0.5}, rng);
  problem.poses.assign(problem.poses.size(), problem.poses[problem.landmark.host]);
  LandmarkBlock block = Linearized(problem);
  EXPECT_LT(block.V(2, 2), 1e-12 * block.V(0, 0));
  for (const double lambda : {0.0, 1e-6}) {
    Eliminate(lambda, block);
    const Reduced reduced = ReduceByLibrary(problem, block);
    ASSERT_TRUE(reduced.H.allFinite() && reduced.b.allFinite() && block.y.allFinite());
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(reduced.H);
    EXPECT_GT(eigen.eigenvalues().minCoeff(), -1e-9 * eigen.eigenvalues().maxCoeff());
    const int column = 6 * problem.landmark.observations[0].frame;
    EXPECT_GT(reduced.H.block(column, column, 3, 3).trace(), 1e4);
  }
}

TEST(VisionFactorTest, APointBehindACameraHasNoRowsAndABoundedCost) {
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
  EXPECT_FALSE(WhitenedError(geometry, problem.landmark, last, 0));
  const LandmarkBlock block = Linearized(problem);
  const LandmarkBlock::View& view = block.views[block.num_views - 1];
  EXPECT_EQ(view.H.norm() + view.b.norm() + view.W.norm(), 0);
  EXPECT_TRUE(std::isfinite(block.cost));
  EXPECT_DOUBLE_EQ(block.cost, LandmarkCost(geometry, problem.landmark, RobustOptions{kHuber}));
  WindowLandmark without = problem.landmark;
  without.observations.pop_back();
  // 30 sigma under Huber's loss.
  EXPECT_NEAR(
      block.cost - LandmarkCost(geometry, without, RobustOptions{kHuber}), kHuber * (30 - 1), 1e-9);
}

TEST(VisionFactorTest, FrozenPosesKeepTheirJacobiansAndUseTheCurrentResidual) {
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
  LinearizeLandmark(geometry, problem.landmark, RobustOptions{1e9}, block);
  LandmarkBlock at_lin;
  LinearizeLandmark(GeometryOf(problem), problem.landmark, RobustOptions{1e9}, at_lin);
  EXPECT_EQ(block.V, at_lin.V);
  Problem moved = problem;
  for (std::size_t i = 0; i < frames.size(); ++i)
    moved.poses[i] = frames[i].x.T_WB;
  EXPECT_NEAR(
      block.cost, LandmarkCost(GeometryOf(moved), problem.landmark, RobustOptions{1e9}), 1e-9);
  EXPECT_GT(std::abs(block.cost - at_lin.cost), 1e-3);
}

}  // namespace
}  // namespace facet
