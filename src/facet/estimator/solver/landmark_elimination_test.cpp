// SPDX-License-Identifier: BSD-2-Clause
// Elimination of a landmark, and the claim that columns for its host are not needed
// (docs/math.md, 3.2).
#include "facet/estimator/solver/landmark_elimination.h"

#include <cmath>
#include <iostream>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "facet/testing/estimator/test_landmark.h"

namespace facet {
namespace {

using testing::Derivative;
using testing::Linearized;
using testing::MakeProblem;
using testing::Measurement;
using testing::Moved;
using testing::Problem;
using testing::Problems;
using testing::RelativeError;

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
  StateLayout layout;
  for (int i = 0; i < n; i += 6)
    layout.pose_column.push_back(i);
  AddDiagonal(block, layout, out.H, out.b);
  SubtractSchur(block, layout, out.H, out.b);
  out.H = MatrixXd(out.H.selfadjointView<Eigen::Lower>());
  return out;
}

// Largest difference in units of what the rows of each column weigh before the elimination.
double ScaledError(const LandmarkBlock& block, const Reduced& a, const Reduced& b) {
  VectorXd weight = VectorXd::Constant(a.b.size(), 1e30);
  for (int v = 0; v < block.num_views; ++v) {
    weight.segment<6>(6 * block.views[v].frame) =
        block.pose_squares[v].H.diagonal().cwiseMax(1.0).cwiseSqrt();
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

TEST(LandmarkEliminationTest, ReducedSystemEqualsTheOneWithHostColumns) {
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

TEST(LandmarkEliminationTest, EliminateFactorisesTheDampedBlock) {
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
TEST(LandmarkEliminationTest, WithoutParallaxRotationIsStillConstrained) {
  Rng rng(5);
  Problem problem = MakeProblem({false, false, 0.5}, rng);
  problem.poses.assign(problem.poses.size(), problem.poses[problem.landmark.host]);
  for (WindowObservation& o : problem.landmark.observations)
    testing::SetMeasurement(problem.landmark.bearing_H, 0, o.sigma_px[0], o);
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

}  // namespace
}  // namespace facet
