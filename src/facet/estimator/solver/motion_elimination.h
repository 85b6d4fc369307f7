// SPDX-License-Identifier: BSD-2-Clause
// Eliminates velocities and biases from the reduced normal equations, one keyframe after the other:
// each touches only its neighbours in time (and the prior), so this costs far less than a dense
// factorisation of everything (docs/math.md, section 4.3).
#pragma once

#include <vector>

#include "facet/estimator/window/state_layout.h"

namespace facet {

/// Reuse one object: it keeps its storage. Not thread-safe.
class MotionElimination {
 public:
  /// Eliminates every motion but the newest from (H, b), later ones first: the prior, which touches
  /// most variables, is on the earliest. H holds its lower triangle. `coupled`: for each frame with
  /// a motion, which variables that motion is in a factor with. The first layout.dense_dim rows and
  /// columns then are the Schur complement. False if not positive definite.
  bool Eliminate(const StateLayout& layout,
                 const std::vector<VariableSet>& coupled,
                 MatrixXd& H,
                 VectorXd& b);

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
    Eigen::Matrix<double, Eigen::Dynamic, 9> X;  // H(neighbours, motion) L^-T
    Vector<9> y;                                 // L^-1 b(motion)
  };

  void FindNeighbours(int frame,
                      const StateLayout& layout,
                      const MatrixXd& H,
                      Eliminated& motion) const;
  void CoupleNeighbours(int frame);

  std::vector<Eliminated> eliminated_;
  int num_eliminated_ = 0;
  std::vector<VariableSet> coupled_;  // grows while motions are eliminated
};

}  // namespace facet
