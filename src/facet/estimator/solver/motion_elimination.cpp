// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/solver/motion_elimination.h"

#include <Eigen/Cholesky>

namespace facet {

namespace {

constexpr int kMotion = SizeOf(Variable::Kind::kMotion);

// IMU factors know the last parameters of the calibration only, the gyroscope's scale. What the
// prior knows of a motion touches all.
bool TouchesGyroScaleOnly(const MatrixXd& H, int motion_column, int calibration_column) {
  return H.block<kMotion, kGyroScale>(motion_column, calibration_column).isZero(0);
}

}  // namespace

// Planes, calibration, poses, the newest motion, then earlier motions: ascending columns.
void MotionElimination::FindNeighbours(int frame,
                                       const StateLayout& layout,
                                       const MatrixXd& H,
                                       Eliminated& motion) const {
  const VariableSet& coupled = coupled_[frame];
  const int num_frames = static_cast<int>(layout.pose_column.size());
  const int num_planes = static_cast<int>(layout.plane_column.size());
  motion.neighbours.clear();
  const auto add_if_coupled = [&](Variable variable) {
    if (!coupled.Contains(variable)) return;
    motion.neighbours.push_back({layout.ColumnOf(variable), SizeOf(variable.kind)});
  };
  for (int k = 0; k < num_planes; ++k)
    add_if_coupled(Variable::Plane(k));
  const int calibration = layout.calibration_column;
  if (calibration >= 0 && coupled.Contains(Variable::Calibration())) {
    const int first = TouchesGyroScaleOnly(H, motion.column, calibration) ? kGyroScale : 0;
    motion.neighbours.push_back({calibration + first, kNumCalibration - first});
  }
  for (int i = 0; i < num_frames; ++i)
    add_if_coupled(Variable::Pose(i));
  add_if_coupled(Variable::Motion(num_frames - 1));
  for (int i = 0; i < frame; ++i)
    add_if_coupled(Variable::Motion(i));
}

// The neighbours are coupled with each other from here on.
void MotionElimination::CoupleNeighbours(int frame) {
  for (int i = 0; i < frame; ++i) {
    if (coupled_[frame].Contains(Variable::Motion(i))) coupled_[i].Insert(coupled_[frame]);
  }
}

namespace {

// The columns of H between a motion and its neighbours, from the lower triangle.
template <class Block, class Columns>
void CollectColumns(const std::vector<Block>& neighbours,
                    int column,
                    const MatrixXd& H,
                    Columns& columns) {
  int offset = 0;
  for (const Block& block : neighbours) {
    if (block.column < column) {
      columns.middleCols(offset, block.size) = H.block(column, block.column, kMotion, block.size);
    } else {
      columns.middleCols(offset, block.size) =
          H.block(block.column, column, block.size, kMotion).transpose();
    }
    offset += block.size;
  }
}

}  // namespace

void MotionElimination::SubtractSchur(const Eliminated& motion, MatrixXd& H, VectorXd& b) {
  const auto size = motion.X.cols();
  update_.setZero(size, size);
  update_.selfadjointView<Eigen::Lower>().rankUpdate(motion.X.transpose());
  int row = 0;
  for (const Block& r : motion.neighbours) {
    b.segment(r.column, r.size).noalias() -=
        motion.X.middleCols(row, r.size).transpose() * motion.y;
    int column = 0;
    for (const Block& c : motion.neighbours) {
      if (column > row) break;
      H.block(r.column, c.column, r.size, c.size) -= update_.block(row, column, r.size, c.size);
      column += c.size;
    }
    row += r.size;
  }
}

bool MotionElimination::Eliminate(const StateLayout& layout,
                                  const std::vector<VariableSet>& coupled,
                                  MatrixXd& H,
                                  VectorXd& b) {
  const int num_frames = static_cast<int>(layout.motion_column.size());
  coupled_ = coupled;
  num_eliminated_ = 0;
  if (eliminated_.size() < coupled.size()) eliminated_.resize(coupled.size());
  for (int k = num_frames - 2; k >= 0; --k) {
    const int column = layout.motion_column[k];
    if (column < 0) continue;
    Eliminated& motion = eliminated_[num_eliminated_++];
    motion.column = column;
    FindNeighbours(k, layout, H, motion);
    int size = 0;
    for (const Block& block : motion.neighbours)
      size += block.size;

    const Eigen::LLT<Matrix<9, 9>> factor(H.block<kMotion, kMotion>(column, column));
    if (factor.info() != Eigen::Success) return false;
    motion.L = factor.matrixL();
    motion.X.resize(kMotion, size);
    CollectColumns(motion.neighbours, column, H, motion.X);
    motion.L.triangularView<Eigen::Lower>().solveInPlace(motion.X);
    motion.y = motion.L.triangularView<Eigen::Lower>().solve(b.segment<kMotion>(column));
    SubtractSchur(motion, H, b);
    CoupleNeighbours(k);
  }
  return true;
}

void MotionElimination::BackSubstitute(VectorXd& step) const {
  for (int k = num_eliminated_ - 1; k >= 0; --k) {
    const Eliminated& motion = eliminated_[k];
    Vector<9> rhs = -motion.y;
    int offset = 0;
    for (const Block& block : motion.neighbours) {
      rhs.noalias() -=
          motion.X.middleCols(offset, block.size) * step.segment(block.column, block.size);
      offset += block.size;
    }
    step.segment<9>(motion.column) = motion.L.transpose().triangularView<Eigen::Upper>().solve(rhs);
  }
}

}  // namespace facet
