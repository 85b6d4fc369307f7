// SPDX-License-Identifier: BSD-2-Clause
// How the odometry's world has drifted: a pose graph of four degrees of freedom over keyframes.
// What the odometry measured between neighbours, and what closures measured across, are relative
// poses with covariances; closures that contradict the others lose their weight.
#pragma once

#include <vector>

#include "facet/loop/upright_pose.h"

namespace facet {

/// A measured pair of nodes: the second as seen from the first, in the odometry's world at the
/// first.
struct GraphEdge {
  int first = 0, second = 0;
  double yaw_rad = 0;                      ///< how the odometry's world at the second is turned
  Vector3d p_first = Vector3d::Zero();     ///< from body to body [m]
  Matrix4d covariance = Matrix4d::Zero();  ///< of yaw and p_first
  /// By what share p_first is too long for each pixel by which disparities are too small.
  double stretch_per_px = 0;
  bool is_closure = false;
  double weight = 1;  ///< closures: 0 to 1, by how far the rest of the graph agrees
};

/// Closures with less weight are not believed: that of one with the error that just is.
inline constexpr double kLeastBelievedWeight = 0.25;

/// A keyframe.
struct GraphNode {
  Vector3d p_W = Vector3d::Zero();  ///< of the body, in the odometry's world
  UprightPose T_MW;                 ///< to the map
  int edge_to_previous = -1;
};

/// All that a graph knows.
struct GraphState {
  std::vector<GraphNode> nodes;
  std::vector<GraphEdge> edges;
  double disparity_error_px = 0;
};

/// Not thread-safe; deterministic.
class MapGraph {
 public:
  MapGraph() = default;
  explicit MapGraph(GraphState state);

  /// A keyframe at p_W in the odometry's world; returns its number. The first one stays where it
  /// is. `drift`: covariance of yaw [rad] and position [m] that the odometry has gained since the
  /// previous node.
  int AddNode(const Vector3d& p_W, const Matrix4d& drift);

  /// The first keyframe of another run, of whose place in the map nothing is known. Its T_MW is the
  /// identity until Move or a closure says more.
  int AddSession(const Vector3d& p_W);

  /// Moves a node and all after it, as they are to each other, by this turn and way in the map.
  void Move(int first_node, const UprightPose& by);

  /// A better position in the odometry's world.
  void MoveNode(int node, const Vector3d& p_W);

  /// What a closure measured, from the older node to the younger one.
  void AddClosure(const GraphEdge& edge);

  /// Takes away the closures that lead from nodes before this one to it and those after it. Returns
  /// for each edge that there was its new number, or -1.
  std::vector<int> RemoveClosuresAcross(int node);

  /// Least squares over all nodes, with weights of closures that are lowered step by step
  /// (graduated non-convexity with the Geman-McClure function).
  void Optimize();

  /// From the odometry's world when the node was taken to the map.
  const UprightPose& T_MW(int node) const { return state_.nodes[node].T_MW; }
  int num_nodes() const { return static_cast<int>(state_.nodes.size()); }
  const std::vector<GraphEdge>& edges() const { return state_.edges; }
  const GraphState& state() const { return state_; }
  /// By how much disparities are too small, as far as closures show it: all have it in common.
  double disparity_error_px() const { return state_.disparity_error_px; }

 private:
  Vector3d BetweenBodies(const GraphEdge& edge) const;  // in the map
  Vector<4> Error(const GraphEdge& edge) const;
  double Chi2(const GraphEdge& edge) const;
  /// One Gauss-Newton step; none if the equations have no solution.
  void Step();

  GraphState state_;
};

}  // namespace facet
