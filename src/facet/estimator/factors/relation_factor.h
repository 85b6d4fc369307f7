// SPDX-License-Identifier: BSD-2-Clause
// Rows of the relations between planes (docs/math.md, section 8; the paper names them as future
// work).
//
// A relation says nothing about where everything is and which way it heads. Its rows are written
// relative to one frame, and so their Jacobians keep quiet about that exactly, wherever the planes
// are linearised.
#pragma once

#include "facet/estimator/factors/robust_options.h"
#include "facet/estimator/window/sliding_window.h"

namespace facet {

/// Whether the frame's pose has columns: the residual turns or shifts with the world.
bool NeedsFrame(PlaneRelationKind kind);

/// Residual and Jacobians of one relation, whitened and weighted. Only the first `num_rows` rows
/// count.
struct RelationRows {
  static constexpr int kMaxRows = 4;
  int num_rows = 0;  ///< 0: the relation says nothing, such as of the heading of a floor
  Vector<kMaxRows> r = Vector<kMaxRows>::Zero();
  Matrix<kMaxRows, 3> J_a = Matrix<kMaxRows, 3>::Zero();  ///< two directions, offset
  Matrix<kMaxRows, 3> J_b = Matrix<kMaxRows, 3>::Zero();
  Matrix<kMaxRows, 6> J_frame = Matrix<kMaxRows, 6>::Zero();  ///< theta p of WindowRelation::frame
  double cost = 0;
};

/// Whitened residual; the rows that do not exist are zero.
Vector<RelationRows::kMaxRows> RelationError(const SlidingWindow& window,
                                             const WindowRelation& relation,
                                             const RelationNoise& noise);

/// Residual at the estimate, Jacobians at the linearisation points.
RelationRows LinearizeRelation(const SlidingWindow& window,
                               const WindowRelation& relation,
                               const RelationNoise& noise);

/// Removes the relations that are violated by more than `max_sigma`. Returns how many.
int DropViolatedRelations(const RelationNoise& noise, double max_sigma, SlidingWindow& window);

}  // namespace facet
