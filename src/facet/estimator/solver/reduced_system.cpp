// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/solver/reduced_system.h"

#include <Eigen/Cholesky>

#include "facet/estimator/solver/landmark_elimination.h"

namespace facet {

// The constant keeps a frame without any measurement (dark, during the start) where it is.
void ReducedSystem::TakeDamped(double lambda, const NormalEquations& equations) {
  const MatrixXd& H = equations.H;
  H_.resize(H.rows(), H.cols());
  H_.triangularView<Eigen::Lower>() = H;
  b_ = equations.b;
  H_.diagonal().array() += lambda * (H.diagonal().array() + 1.0);
}

void ReducedSystem::EliminateLandmarks(double lambda, LinearizedWindow& linear) {
  TakeDamped(lambda, linear.equations);
  for (int k = 0; k < linear.num_landmarks; ++k) {
    Eliminate(lambda, linear.landmarks[k]);
    SubtractSchur(linear.landmarks[k], linear.layout(), H_, b_);
  }
}

// The same, but what the landmarks say is kept apart until the columns of mount and time offset are
// made of it.
void ReducedSystem::EliminateWithCalibration(double lambda, LinearizedWindow& linear) {
  const StateLayout& layout = linear.layout();
  vision_H_ = linear.vision_H;
  vision_b_ = linear.vision_b;
  for (int k = 0; k < linear.num_landmarks; ++k) {
    Eliminate(lambda, linear.landmarks[k]);
    SubtractSchur(linear.landmarks[k], layout, vision_H_, vision_b_);
  }
  FillMountColumns(linear.mounts, layout, vision_H_, vision_b_);
  TakeDamped(lambda, linear.equations);
  auto dense = H_.topLeftCorner(layout.dense_dim, layout.dense_dim);
  dense.diagonal() += lambda * linear.vision_H.diagonal();
  dense.triangularView<Eigen::Lower>() += vision_H_;
  b_.head(layout.dense_dim) += vision_b_;
}

bool ReducedSystem::Solve(double lambda, LinearizedWindow& linear) {
  const StateLayout& layout = linear.layout();
  dense_dim_ = layout.dense_dim;
  if (layout.calibration_column < 0) {
    EliminateLandmarks(lambda, linear);
  } else {
    EliminateWithCalibration(lambda, linear);
  }
  if (!motions_.Eliminate(layout, linear.coupled_with_motion, H_, b_)) return false;
  Eigen::Ref<MatrixXd> dense = H_.topLeftCorner(dense_dim_, dense_dim_);
  if (Eigen::LLT<Eigen::Ref<MatrixXd>>(dense).info() != Eigen::Success) return false;
  step_.setZero(layout.dim);
  auto dense_step = step_.head(dense_dim_);
  dense_step = -b_.head(dense_dim_);
  factor().triangularView<Eigen::Lower>().solveInPlace(dense_step);
  factor().transpose().triangularView<Eigen::Upper>().solveInPlace(dense_step);
  motions_.BackSubstitute(step_);
  return step_.allFinite();
}

}  // namespace facet
