// SPDX-License-Identifier: BSD-2-Clause
// Eliminates velocities and biases from the reduced normal equations, one keyframe after the other:
// each touches only its neighbours in time (and the prior), so this costs far less than a dense
// factorisation of everything (docs/math.md, section 4.3).
#pragma once

#include <vector>

#include "facet/estimator/window/sliding_window.h"

namespace facet {

/// Which columns belong to whom: planes (tangent of the normal, offset), all poses (theta p), the
/// newest motion (v b_g b_a), the other motions.
struct StateLayout {
  std::vector<int> plane_column;   ///< by plane index
  std::vector<int> pose_column;    ///< by frame index
  std::vector<int> motion_column;  ///< by frame index, -1 without motion
  int dim = 0;
  int dense_dim = 0;  ///< columns of planes, poses and the newest motion: not eliminated here
};

StateLayout MakeLayout(const SlidingWindow& window);

/// Reuse one object: it keeps its storage. Not thread-safe.
class MotionElimination {
 public:
  /// Eliminates every motion but the newest from (H, b); H holds its lower triangle. The first
  /// layout.dense_dim rows and columns then are the Schur complement. False if not positive
  /// definite.
  bool Eliminate(const SlidingWindow& window, const StateLayout& layout, MatrixXd& H, VectorXd& b);

  /// Fills the eliminated part of `step` from its first dense_dim entries (solution of H step =
  /// -b).
  void BackSubstitute(VectorXd& step) const;

 private:
  struct Block {
    int column;
    int size;
  };
  struct Eliminated {
    int column = 0;
    std::vector<Block> neighbours;
    Matrix<9, 9> L;
    Eigen::Matrix<double, 9, Eigen::Dynamic> X;  // L^-1 H(motion, neighbours)
    Vector<9> y;                                 // L^-1 b(motion)
  };

  void FindNeighbours(const SlidingWindow& window, const StateLayout& layout);

  std::vector<Eliminated> eliminated_;
  int num_eliminated_ = 0;
  std::vector<std::vector<char>> adjacent_;  // [motion frame][2 * frame + is_motion], then planes
  MatrixXd update_;
};

}  // namespace facet
