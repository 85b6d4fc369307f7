// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/solver/motion_elimination.h"

#include <Eigen/Cholesky>

namespace facet {

StateLayout MakeLayout(const SlidingWindow& window) {
  const std::vector<WindowFrame>& frames = window.frames;
  StateLayout layout;
  for (std::size_t k = 0; k < window.planes.size(); ++k) {
    layout.plane_column.push_back(layout.dim);
    layout.dim += 3;
  }
  for (std::size_t i = 0; i < frames.size(); ++i) {
    layout.pose_column.push_back(layout.dim);
    layout.dim += 6;
  }
  layout.motion_column.assign(frames.size(), -1);
  if (!frames.empty() && frames.back().has_motion) {
    layout.motion_column.back() = layout.dim;
    layout.dim += 9;
  }
  layout.dense_dim = layout.dim;
  for (std::size_t i = 0; i + 1 < frames.size(); ++i) {
    if (!frames[i].has_motion) continue;
    layout.motion_column[i] = layout.dim;
    layout.dim += 9;
  }
  return layout;
}

void MotionElimination::FindNeighbours(const SlidingWindow& window, const StateLayout& layout) {
  const std::size_t n = window.frames.size();
  adjacent_.resize(n);
  for (auto& row : adjacent_)
    row.assign(2 * n + window.planes.size(), 0);
  for (std::size_t i = 0; i < n; ++i) {
    if (layout.motion_column[i] >= 0) adjacent_[i][2 * i] = 1;
  }
  for (std::size_t j = 1; j < n; ++j) {
    if (!window.frames[j].has_imu_link) continue;
    for (std::size_t a : {j - 1, j}) {
      for (std::size_t c : {j - 1, j})
        adjacent_[a][2 * c] = adjacent_[a][2 * c + 1] = 1;
    }
  }
  for (const MarginalPrior::Block& a : window.prior.blocks) {
    if (!a.is_motion) continue;
    for (const MarginalPrior::Block& c : window.prior.blocks) {
      const int column = c.IsPlane() ? static_cast<int>(2 * n) + window.IndexOf(c.plane)
                                     : 2 * window.IndexOf(c.frame) + (c.is_motion ? 1 : 0);
      adjacent_[window.IndexOf(a.frame)][column] = 1;
    }
  }
}

bool MotionElimination::Eliminate(const SlidingWindow& window,
                                  const StateLayout& layout,
                                  MatrixXd& H,
                                  VectorXd& b) {
  const int n = static_cast<int>(window.frames.size());
  const int num_planes = static_cast<int>(window.planes.size());
  FindNeighbours(window, layout);
  num_eliminated_ = 0;
  if (eliminated_.size() < window.frames.size()) eliminated_.resize(window.frames.size());
  for (int k = 0; k + 1 < n; ++k) {
    if (layout.motion_column[k] < 0) continue;
    Eliminated& e = eliminated_[num_eliminated_++];
    e.column = layout.motion_column[k];
    // Planes, poses, the newest motion, then later motions: ascending columns.
    e.neighbours.clear();
    for (int p = 0; p < num_planes; ++p) {
      if (adjacent_[k][2 * n + p]) e.neighbours.push_back({layout.plane_column[p], 3});
    }
    for (int i = 0; i < n; ++i) {
      if (adjacent_[k][2 * i]) e.neighbours.push_back({layout.pose_column[i], 6});
    }
    if (adjacent_[k][2 * n - 1]) e.neighbours.push_back({layout.motion_column[n - 1], 9});
    for (int i = k + 1; i + 1 < n; ++i) {
      if (adjacent_[k][2 * i + 1]) e.neighbours.push_back({layout.motion_column[i], 9});
    }
    int size = 0;
    for (const Block& block : e.neighbours)
      size += block.size;

    const Eigen::LLT<Matrix<9, 9>> factor(H.block<9, 9>(e.column, e.column));
    if (factor.info() != Eigen::Success) return false;
    e.L = factor.matrixL();
    e.X.resize(9, size);
    int offset = 0;
    for (const Block& block : e.neighbours) {
      if (block.column < e.column) {
        e.X.middleCols(offset, block.size) = H.block(e.column, block.column, 9, block.size);
      } else {
        e.X.middleCols(offset, block.size) =
            H.block(block.column, e.column, block.size, 9).transpose();
      }
      offset += block.size;
    }
    e.L.triangularView<Eigen::Lower>().solveInPlace(e.X);
    e.y = e.L.triangularView<Eigen::Lower>().solve(b.segment<9>(e.column));

    update_.setZero(size, size);
    update_.selfadjointView<Eigen::Lower>().rankUpdate(e.X.transpose());
    int row = 0;
    for (const Block& r : e.neighbours) {
      b.segment(r.column, r.size).noalias() -= e.X.middleCols(row, r.size).transpose() * e.y;
      int column = 0;
      for (const Block& c : e.neighbours) {
        if (column > row) break;
        H.block(r.column, c.column, r.size, c.size) -= update_.block(row, column, r.size, c.size);
        column += c.size;
      }
      row += r.size;
    }
    // The neighbours are adjacent to each other from here on.
    for (int i = k + 1; i < n; ++i) {
      if (!adjacent_[k][2 * i + 1]) continue;
      for (int c = 0; c < 2 * n + num_planes; ++c)
        adjacent_[i][c] |= adjacent_[k][c];
    }
  }
  return true;
}

void MotionElimination::BackSubstitute(VectorXd& step) const {
  for (int k = num_eliminated_ - 1; k >= 0; --k) {
    const Eliminated& e = eliminated_[k];
    Vector<9> rhs = -e.y;
    int offset = 0;
    for (const Block& block : e.neighbours) {
      rhs.noalias() -= e.X.middleCols(offset, block.size) * step.segment(block.column, block.size);
      offset += block.size;
    }
    step.segment<9>(e.column) = e.L.transpose().triangularView<Eigen::Upper>().solve(rhs);
  }
}

}  // namespace facet
