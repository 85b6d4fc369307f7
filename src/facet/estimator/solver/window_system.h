// SPDX-License-Identifier: BSD-2-Clause
// Normal equations of the window: assembled from vision, IMU and prior, reduced to the frames.
// Equations (4.x) of docs/math.md. Landmarks are eliminated one by one (they are "structureless").
#pragma once

#include <vector>

#include "facet/estimator/factors/vision_factor.h"
#include "facet/estimator/solver/motion_elimination.h"
#include "facet/estimator/window/sliding_window.h"

namespace facet {

/// Current value of delta of a prior block (zero for what is not frozen).
VectorXd PriorDelta(const SlidingWindow& window);

/// Adds the quadratic prior; returns its cost.
double AddPrior(const SlidingWindow& window, const StateLayout& layout, MatrixXd* H, VectorXd* b);

/// Adds the start prior; returns its cost. H and b may be null (cost only).
double AddStartPrior(const SlidingWindow& window,
                     const StateLayout& layout,
                     MatrixXd* H,
                     VectorXd* b);

/// Adds the IMU link that ends in frame `j`; returns its cost. H and b may be null (cost only).
double AddImuLink(
    const SlidingWindow& window, const StateLayout& layout, int j, MatrixXd* H, VectorXd* b);

/// Adds a relation between planes; returns its cost. H and b may be null (cost only).
double AddPlaneRelation(const SlidingWindow& window,
                        const StateLayout& layout,
                        const WindowRelation& relation,
                        const RelationNoise& noise,
                        MatrixXd* H,
                        VectorXd* b);

/// Adds a sighting of a plane; returns its cost. H and b may be null (cost only).
double AddPlaneSighting(const SlidingWindow& window,
                        const StateLayout& layout,
                        const PlaneSighting& sighting,
                        double huber_sigma,
                        MatrixXd* H,
                        VectorXd* b);

/// Whether the landmark constrains anything: it has a distance and is seen from two frames, or from
/// one and lies on a plane.
bool IsConstraining(const WindowLandmark& landmark);

/// Linearised window. Reuse one object: it keeps its storage. Not thread-safe.
class WindowSystem {
 public:
  explicit WindowSystem(const StereoRig& rig) : geometry_(rig) {}

  /// Linearises everything at the current estimate (frozen variables at theirs).
  void Linearize(const SlidingWindow& window, const RobustOptions& robust);

  /// Cost at the window's current estimate, without linearising.
  double Cost(const SlidingWindow& window, const RobustOptions& robust);

  /// Median of the norms of the whitened left errors in the newest frame at the window's current
  /// estimate; 0 if it sees nothing that constrains.
  double NewestError(const SlidingWindow& window);

  /// Reduces with damping lambda and solves; false if the matrix is not positive definite.
  bool Solve(const SlidingWindow& window, double lambda);

  /// Moves frames, planes and landmarks by the last solution.
  void ApplyStep(SlidingWindow& window);

  double cost() const { return cost_; }
  const VectorXd& step() const { return step_; }
  const StateLayout& layout() const { return layout_; }
  const FrameGeometry& geometry() const { return geometry_; }

  /// What landmarks and sightings say about each plane, poses given, from the last Solve:
  /// information on two tangent directions and offset.
  std::vector<Matrix3d> PlaneInformation() const;

  /// Joint covariance of the newest pose and each plane from the last factorisation: theta p, two
  /// tangent directions, offset.
  std::vector<Matrix<9, 9>> PlaneCovariances() const;

  /// Marginal covariance of the newest frame (with motion) from the last factorisation: theta p v
  /// b_g b_a.
  Matrix<15, 15> NewestFrameCovariance() const;

 private:
  void LinearizeSightings(const SlidingWindow& window, const RobustOptions& robust);
  void LinearizeVision(const SlidingWindow& window, const RobustOptions& robust);
  auto Factor() const { return reduced_H_.topLeftCorner(layout_.dense_dim, layout_.dense_dim); }

  FrameGeometry geometry_;
  StateLayout layout_;
  std::vector<LandmarkBlock> blocks_;
  std::vector<Matrix3d> sighted_;  // information of the sightings on each plane
  int num_blocks_ = 0;
  MatrixXd H_;  // everything but the eliminated landmarks
  VectorXd b_;
  std::vector<double> errors_;
  // Lower triangle only. Solve, if it succeeds, leaves the Cholesky factor of planes, poses and the
  // newest motion in the first dense_dim columns.
  MatrixXd reduced_H_;
  VectorXd reduced_b_;
  MotionElimination motions_;
  VectorXd step_;
  double cost_ = 0;
};

/// Adds the landmark's blocks on the diagonal.
void AddDiagonal(const LandmarkBlock& block, const StateLayout& layout, MatrixXd& H, VectorXd& b);

/// Subtracts the eliminated landmark from (H, b); lower triangle of plane and pose columns only.
void SubtractSchur(const LandmarkBlock& block, const StateLayout& layout, MatrixXd& H, VectorXd& b);

}  // namespace facet
