// SPDX-License-Identifier: BSD-2-Clause
#include "facet/loop/map_graph.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/LU>
#include <Eigen/SparseCholesky>

#include "facet/base/check.h"

namespace facet {

namespace {

constexpr double kMaxChi2 = 13.3;           // 99 % of four degrees of freedom
constexpr double kSigmaDisparity_px = 0.1;  // of a careful calibration

Vector3d TurnBack(double yaw_rad, const Vector3d& x) {
  const double c = std::cos(yaw_rad), s = std::sin(yaw_rad);
  return {c * x.x() + s * x.y(), -s * x.x() + c * x.y(), x.z()};
}

}  // namespace

MapGraph::MapGraph(GraphState state) : state_(std::move(state)) {
  for (const GraphEdge& edge : state_.edges)
    FACET_CHECK(edge.first >= 0 && edge.first < edge.second && edge.second < num_nodes());
}

int MapGraph::AddSession(const Vector3d& p_W) {
  // Weak enough to say nothing, and enough for the equations to have a solution.
  constexpr double kAnywhere_m = 1e4, kAnyHeading_rad = 100;
  const Vector<4> sigma(kAnyHeading_rad, kAnywhere_m, kAnywhere_m, kAnywhere_m);
  const int node = AddNode(p_W, sigma.cwiseAbs2().asDiagonal());
  state_.nodes[node].T_MW = UprightPose();
  return node;
}

void MapGraph::Move(int first_node, const UprightPose& by) {
  FACET_CHECK(first_node >= 0);
  for (int node = first_node; node < num_nodes(); ++node)
    state_.nodes[node].T_MW = by * state_.nodes[node].T_MW;
}

int MapGraph::AddNode(const Vector3d& p_W, const Matrix4d& drift) {
  GraphNode node;
  node.p_W = p_W;
  const int index = num_nodes();
  if (index > 0) {
    const GraphNode& previous = state_.nodes.back();
    node.T_MW = previous.T_MW;
    GraphEdge edge;
    edge.first = index - 1;
    edge.second = index;
    edge.p_first = p_W - previous.p_W;
    edge.covariance = drift;
    node.edge_to_previous = static_cast<int>(state_.edges.size());
    state_.edges.push_back(edge);
  }
  state_.nodes.push_back(node);
  return index;
}

void MapGraph::MoveNode(int node, const Vector3d& p_W) {
  FACET_CHECK(node >= 0 && node < num_nodes());
  const Vector3d moved = p_W - state_.nodes[node].p_W;
  state_.nodes[node].p_W = p_W;
  if (state_.nodes[node].edge_to_previous >= 0)
    state_.edges[state_.nodes[node].edge_to_previous].p_first += moved;
  if (node + 1 < num_nodes())
    state_.edges[state_.nodes[node + 1].edge_to_previous].p_first -= moved;
}

void MapGraph::AddClosure(const GraphEdge& edge) {
  FACET_CHECK(edge.first >= 0 && edge.first < edge.second && edge.second < num_nodes());
  state_.edges.push_back(edge);
  state_.edges.back().is_closure = true;
}

std::vector<int> MapGraph::RemoveClosuresAcross(int node) {
  std::vector<int> numbers;
  int next = 0;
  for (const GraphEdge& edge : state_.edges) {
    const bool leaves = edge.is_closure && edge.first < node && edge.second >= node;
    numbers.push_back(leaves ? -1 : next++);
  }
  std::erase_if(state_.edges, [&](const GraphEdge& edge) {
    return edge.is_closure && edge.first < node && edge.second >= node;
  });
  for (GraphNode& n : state_.nodes) {
    if (n.edge_to_previous >= 0) n.edge_to_previous = numbers[n.edge_to_previous];
  }
  return numbers;
}

Vector3d MapGraph::BetweenBodies(const GraphEdge& edge) const {
  const GraphNode &a = state_.nodes[edge.first], &b = state_.nodes[edge.second];
  return b.T_MW * b.p_W - a.T_MW * a.p_W;
}

Vector<4> MapGraph::Error(const GraphEdge& edge) const {
  const GraphNode &a = state_.nodes[edge.first], &b = state_.nodes[edge.second];
  Vector<4> error;
  error(0) = std::remainder(b.T_MW.yaw_rad - a.T_MW.yaw_rad - edge.yaw_rad, 2 * std::numbers::pi);
  error.tail<3>() = TurnBack(a.T_MW.yaw_rad, BetweenBodies(edge)) -
                    (1 - edge.stretch_per_px * state_.disparity_error_px) * edge.p_first;
  return error;
}

double MapGraph::Chi2(const GraphEdge& edge) const {
  const Vector<4> error = Error(edge);
  return error.dot(edge.covariance.inverse() * error);
}

void MapGraph::Optimize() {
  constexpr double kEasing = 1.6;
  constexpr double kLargestMu = 1e12;
  double mu = 1;
  for (const GraphEdge& edge : state_.edges) {
    if (edge.is_closure) mu = std::max(mu, 2 * Chi2(edge) / kMaxChi2);
  }
  mu = std::min(mu, kLargestMu);
  for (bool is_last = false; !is_last; mu = std::max(1.0, mu / kEasing)) {
    is_last = mu == 1;
    const int steps = is_last ? 4 : 1;
    for (int step = 0; step < steps; ++step) {
      for (GraphEdge& edge : state_.edges) {
        if (!edge.is_closure) continue;
        const double limit = mu * kMaxChi2;
        const double share = limit / (limit + Chi2(edge));
        edge.weight = share * share;
      }
      Step();
    }
  }
}

void MapGraph::Step() {
  const int n = 4 * (num_nodes() - 1) + 1;
  if (n <= 1) return;
  std::vector<Eigen::Triplet<double>> entries;
  VectorXd g = VectorXd::Zero(n);
  const auto add = [&](int row_node, int column_node, const Matrix4d& block) {
    if (row_node == 0 || column_node == 0) return;
    for (int r = 0; r < 4; ++r) {
      for (int c = 0; c < 4; ++c)
        entries.emplace_back(4 * (row_node - 1) + r, 4 * (column_node - 1) + c, block(r, c));
    }
  };
  // Variables: yaw of T_MW and the body's position in the map, for each node but the first; last
  // the common error of disparities.
  const int common = n - 1;
  const double information_common = 1 / (kSigmaDisparity_px * kSigmaDisparity_px);
  entries.emplace_back(common, common, information_common);
  g(common) = information_common * state_.disparity_error_px;
  for (const GraphEdge& edge : state_.edges) {
    const Vector<4> error = Error(edge);
    const double yaw = state_.nodes[edge.first].T_MW.yaw_rad;
    const Matrix4d information = edge.weight * edge.covariance.inverse();
    const Vector3d p = TurnBack(yaw, BetweenBodies(edge));
    Matrix4d J_first = Matrix4d::Zero(), J_second = Matrix4d::Zero();
    J_first(0, 0) = -1;
    J_second(0, 0) = 1;
    J_first.block<3, 1>(1, 0) = Vector3d(p.y(), -p.x(), 0);
    Matrix3d R_back;
    for (int axis = 0; axis < 3; ++axis)
      R_back.col(axis) = TurnBack(yaw, Vector3d::Unit(axis));
    J_first.bottomRightCorner<3, 3>() = -R_back;
    J_second.bottomRightCorner<3, 3>() = R_back;
    const Matrix4d W_first = information * J_first, W_second = information * J_second;
    add(edge.first, edge.first, J_first.transpose() * W_first);
    add(edge.first, edge.second, J_first.transpose() * W_second);
    add(edge.second, edge.first, J_second.transpose() * W_first);
    add(edge.second, edge.second, J_second.transpose() * W_second);
    if (edge.stretch_per_px != 0) {
      Vector<4> J_common = Vector<4>::Zero();
      J_common.tail<3>() = edge.stretch_per_px * edge.p_first;
      const Vector<4> W_common = information * J_common;
      entries.emplace_back(common, common, J_common.dot(W_common));
      g(common) += W_common.dot(error);
      const auto add_cross = [&](int node, const Matrix4d& J) {
        if (node == 0) return;
        const Vector<4> cross = J.transpose() * W_common;
        for (int r = 0; r < 4; ++r) {
          entries.emplace_back(4 * (node - 1) + r, common, cross(r));
          entries.emplace_back(common, 4 * (node - 1) + r, cross(r));
        }
      };
      add_cross(edge.first, J_first);
      add_cross(edge.second, J_second);
    }
    if (edge.first > 0) g.segment<4>(4 * (edge.first - 1)) += W_first.transpose() * error;
    if (edge.second > 0) g.segment<4>(4 * (edge.second - 1)) += W_second.transpose() * error;
  }
  Eigen::SparseMatrix<double> H(n, n);
  H.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> ldlt(H);
  if (ldlt.info() != Eigen::Success) return;
  const VectorXd x = -ldlt.solve(g);
  if (!x.allFinite()) return;
  state_.disparity_error_px += x(common);
  for (int i = 1; i < num_nodes(); ++i) {
    GraphNode& node = state_.nodes[i];
    const Vector3d p_M = node.T_MW * node.p_W + x.segment<3>(4 * (i - 1) + 1);
    node.T_MW.yaw_rad = std::remainder(node.T_MW.yaw_rad + x(4 * (i - 1)), 2 * std::numbers::pi);
    node.T_MW.p.setZero();
    node.T_MW.p = p_M - node.T_MW * node.p_W;
  }
}

}  // namespace facet
