// SPDX-License-Identifier: BSD-2-Clause
// Reduces the normal equations to what is dense, factorises that and solves: the second of the
// three parts of a solve (linearise, reduce, step).
#pragma once

#include "facet/estimator/solver/linearized_window.h"
#include "facet/estimator/solver/motion_elimination.h"

namespace facet {

/// Reuse one object: it keeps its storage. Not thread-safe.
class ReducedSystem {
 public:
  /// Solves (H + lambda diag H) step = -b. Eliminates the landmarks, whose blocks keep what their
  /// own steps need, then all motions but the newest. False if the matrix is not positive definite.
  bool Solve(double lambda, LinearizedWindow& linear);

  /// Of frames and planes, in the columns of the layout.
  const VectorXd& step() const { return step_; }

  /// Lower Cholesky factor of the dense columns (StateLayout::dense_dim), from the last Solve that
  /// succeeded. Only its lower triangle means anything.
  auto factor() const { return H_.topLeftCorner(dense_dim_, dense_dim_); }

 private:
  void TakeDamped(double lambda, const NormalEquations& equations);
  void EliminateLandmarks(double lambda, LinearizedWindow& linear);
  void EliminateWithCalibration(double lambda, LinearizedWindow& linear);

  MatrixXd H_;  // lower triangle
  VectorXd b_;
  MatrixXd vision_H_;  // what the landmarks add to it
  VectorXd vision_b_;
  int dense_dim_ = 0;
  MotionElimination motions_;
  VectorXd step_;
};

}  // namespace facet
