// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/solver/motion_elimination.h"

#include <Eigen/Cholesky>

#include "facet/estimator/factors/vision_kernels.h"

namespace facet {

namespace {

constexpr int kMotion = SizeOf(Variable::Kind::kMotion);
static_assert(kMotion == kEliminated);

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
  // Neighbours that lie side by side are one block.
  const auto add = [&](int column, int size) {
    if (!motion.neighbours.empty()) {
      Block& last = motion.neighbours.back();
      if (last.column + last.size == column) {
        last.size += size;
        return;
      }
    }
    motion.neighbours.push_back({column, size});
  };
  const auto add_if_coupled = [&](Variable variable) {
    if (coupled.Contains(variable)) add(layout.ColumnOf(variable), SizeOf(variable.kind));
  };
  for (int k = 0; k < num_planes; ++k)
    add_if_coupled(Variable::Plane(k));
  const int calibration = layout.calibration_column;
  if (calibration >= 0 && coupled.Contains(Variable::Calibration())) {
    const int first = TouchesGyroScaleOnly(H, motion.column, calibration) ? kGyroScale : 0;
    add(calibration + first, kNumCalibration - first);
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

// The rows of H between a motion and its neighbours, from the lower triangle.
template <class Block, class Rows>
void CollectRows(const std::vector<Block>& neighbours, int column, const MatrixXd& H, Rows& rows) {
  int row = 0;
  for (const Block& block : neighbours) {
    if (block.column > column) {
      rows.middleRows(row, block.size) = H.block(block.column, column, block.size, kMotion);
    } else {
      rows.middleRows(row, block.size) =
          H.block(column, block.column, kMotion, block.size).transpose();
    }
    row += block.size;
  }
}

template <class Block>
void SubtractSchur(const std::vector<Block>& neighbours,
                   Eigen::Matrix<double, Eigen::Dynamic, kMotion>& X,
                   const Vector<kMotion>& y,
                   MatrixXd& H,
                   VectorXd& b) {
  const auto rows_of = [&X](int row, int size) {
    return NineColumns{X.data() + row, X.outerStride(), size};
  };
  int row = 0;
  for (const Block& r : neighbours) {
    b.segment(r.column, r.size).noalias() -= X.middleRows(row, r.size) * y;
    int column = 0;
    for (const Block& c : neighbours) {
      if (column > row) break;
      BestKernels().subtract_motion(
          rows_of(row, r.size), rows_of(column, c.size), &H(r.column, c.column), H.outerStride());
      column += c.size;
    }
    row += r.size;
  }
}

}  // namespace

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
    motion.X.resize(size, kMotion);
    CollectRows(motion.neighbours, column, H, motion.X);
    const Vector<kMotion> inverse_diagonal = motion.L.diagonal().cwiseInverse();
    BestKernels().solve_motion(
        motion.L.data(), inverse_diagonal.data(), {motion.X.data(), size, size});
    motion.y = motion.L.triangularView<Eigen::Lower>().solve(b.segment<kMotion>(column));
    SubtractSchur(motion.neighbours, motion.X, motion.y, H, b);
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
      rhs.noalias() -= motion.X.middleRows(offset, block.size).transpose() *
                       step.segment(block.column, block.size);
      offset += block.size;
    }
    step.segment<9>(motion.column) = motion.L.transpose().triangularView<Eigen::Upper>().solve(rhs);
  }
}

}  // namespace facet
