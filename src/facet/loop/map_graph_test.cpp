// SPDX-License-Identifier: BSD-2-Clause
#include "facet/loop/map_graph.h"

#include <gtest/gtest.h>

#include "facet/base/random.h"

namespace facet {
namespace {

Matrix4d Diagonal(double sigma_rad, double sigma_m) {
  Vector4d variance = Vector4d::Constant(sigma_m * sigma_m);
  variance(0) = sigma_rad * sigma_rad;
  return variance.asDiagonal();
}

/// Laps on a circle with an odometry whose world turns and moves.
struct Laps {
  explicit Laps(int num, std::uint64_t seed) {
    Rng random(seed);
    UprightPose T_WM;  // from the true world to the odometry's
    for (int i = 0; i < num; ++i) {
      const double angle = 0.2 * i;
      p_true.push_back(
          Vector3d(5 * std::cos(angle), 5 * std::sin(angle), 0.3 * std::sin(2 * angle)));
      // The odometry turns about where the body is.
      const double turn = i > 0 ? kDrift_rad * random.Normal() : 0;
      const Vector3d shift = i > 0 ? Vector3d(kDrift_m * random.Normal3()) : Vector3d::Zero();
      const Vector3d body_W = T_WM * p_true.back();
      T_WM.yaw_rad += turn;
      T_WM.p += body_W + shift - T_WM * p_true.back();
      worlds.push_back(T_WM);
      graph.AddNode(T_WM * p_true.back(), Diagonal(kDrift_rad, kDrift_m));
    }
  }

  GraphEdge Closure(int a, int b, const Vector4d& error = Vector4d::Zero()) const {
    GraphEdge edge;
    edge.first = a;
    edge.second = b;
    const UprightPose T_ab = worlds[a] * worlds[b].Inverse();
    edge.yaw_rad = T_ab.yaw_rad + error(0);
    edge.p_first = worlds[a] * p_true[b] - worlds[a] * p_true[a] + error.tail<3>();
    edge.covariance = Diagonal(1e-3, 3e-3);
    return edge;
  }

  double WorstError_m() const {
    double worst = 0;
    for (int i = 0; i < graph.num_nodes(); ++i) {
      const Vector3d p_M = graph.T_MW(i) * (worlds[i] * p_true[i]);
      worst = std::max(worst, (p_M - p_true[i]).norm());
    }
    return worst;
  }

  static constexpr double kDrift_rad = 3e-3, kDrift_m = 0.01;
  MapGraph graph;
  std::vector<Vector3d> p_true;
  std::vector<UprightPose> worlds;  // T_WM by node
};

TEST(MapGraphTest, WithoutClosuresNothingMoves) {
  Laps laps(40, 1);
  laps.graph.Optimize();
  for (int i = 0; i < laps.graph.num_nodes(); ++i) {
    EXPECT_LT(std::abs(laps.graph.T_MW(i).yaw_rad), 1e-12);
    EXPECT_LT(laps.graph.T_MW(i).p.norm(), 1e-9);
  }
}

TEST(MapGraphTest, ClosuresAcrossANodeGoAndTheOthersStayWhatTheyAre) {
  constexpr int kNode = 40;
  Laps laps(70, 3);
  for (int b = 32; b < 70; b += 2)
    laps.graph.AddClosure(laps.Closure(b - 31, b));
  const std::vector<GraphEdge> before = laps.graph.edges();
  const std::vector<int> numbers = laps.graph.RemoveClosuresAcross(kNode);
  ASSERT_EQ(numbers.size(), before.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    const bool is_across =
        before[i].is_closure && before[i].first < kNode && before[i].second >= kNode;
    ASSERT_EQ(numbers[i] < 0, is_across) << i;
    if (is_across) continue;
    EXPECT_EQ(laps.graph.edges()[numbers[i]].first, before[i].first);
    EXPECT_EQ(laps.graph.edges()[numbers[i]].second, before[i].second);
  }
  EXPECT_EQ(before.size() - laps.graph.edges().size(), 15U);
  for (int node = 1; node < laps.graph.num_nodes(); ++node)
    EXPECT_EQ(laps.graph.edges()[laps.graph.state().nodes[node].edge_to_previous].second, node);
}

TEST(MapGraphTest, ExactClosuresTakeTheDriftBack) {
  Laps laps(70, 2);
  const double before_m = laps.WorstError_m();
  ASSERT_GT(before_m, 0.1);
  for (int b = 32; b < 70; b += 2)
    laps.graph.AddClosure(laps.Closure(b - 31, b));
  laps.graph.Optimize();
  EXPECT_LT(laps.WorstError_m(), 0.5 * before_m);
  // The end is tied to the first lap.
  const Vector3d end_M = laps.graph.T_MW(69) * (laps.worlds[69] * laps.p_true[69]);
  const Vector3d tie_M = laps.graph.T_MW(38) * (laps.worlds[38] * laps.p_true[38]);
  EXPECT_LT(((end_M - tie_M) - (laps.p_true[69] - laps.p_true[38])).norm(), 0.05);
}

TEST(MapGraphTest, AWrongClosureLosesItsWeight) {
  Laps laps(70, 3);
  for (int b = 32; b < 70; b += 2)
    laps.graph.AddClosure(laps.Closure(b - 31, b));
  laps.graph.Optimize();
  const double right_m = laps.WorstError_m();
  laps.graph.AddClosure(laps.Closure(10, 60, Vector4d(0.3, 2, -1, 0.5)));
  laps.graph.Optimize();
  EXPECT_LT(laps.graph.edges().back().weight, 0.01);
  EXPECT_NEAR(laps.WorstError_m(), right_m, 0.01);
}

// Ways that are measured too long by one share of their length, as by wrong disparities.
TEST(MapGraphTest, AStretchThatAllClosuresShareIsFound) {
  Laps laps(70, 4);
  constexpr double kStretchPerPx = 0.1, kError_px = 0.15;
  for (int b = 34; b < 70; b += 1) {
    GraphEdge edge = laps.Closure(b - 27, b);  // well apart from each other
    edge.stretch_per_px = kStretchPerPx;
    edge.p_first /= 1 - kStretchPerPx * kError_px;
    laps.graph.AddClosure(edge);
  }
  laps.graph.Optimize();
  EXPECT_NEAR(laps.graph.disparity_error_px(), kError_px, 0.3 * kError_px);
}

TEST(MapGraphTest, AMovedNodeTakesItsEdgesAlong) {
  Laps laps(10, 5);
  const Vector3d p_W = laps.worlds[4] * laps.p_true[4] + Vector3d(0.1, 0, 0);
  laps.graph.MoveNode(4, p_W);
  laps.graph.Optimize();
  EXPECT_LT((laps.graph.T_MW(4) * p_W - p_W).norm(), 1e-9);
  EXPECT_LT(laps.graph.T_MW(9).p.norm(), 1e-9);
}

}  // namespace
}  // namespace facet
