// SPDX-License-Identifier: BSD-2-Clause
// Rows of the relations between planes (docs/math.md, section 8; the paper names them as future
// work).
//
// A relation says nothing about where everything is and which way it heads. Its rows are written
// relative to one frame, and so their Jacobians keep quiet about that exactly, wherever the planes
// are linearised.
#pragma once

#include "facet/estimator/factors/factor.h"
#include "facet/estimator/factors/factor_noise.h"

namespace facet {

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

class RelationFactor {
 public:
  RelationFactor(const SlidingWindow& window,
                 const WindowRelation& relation,
                 const RelationNoise& noise);

  /// Whitened residual; the rows that do not exist are zero.
  Vector<RelationRows::kMaxRows> Error() const;
  RelationRows Linearize() const;

  double Cost() const;
  double AddTo(NormalEquations& equations) const;

  /// A relation is used up when one of its planes leaves. When its frame leaves, another frame
  /// takes it over.
  bool IsUsedUp(const MarginalizationPlan& plan) const {
    return plan.Drops(plane_a_) || plan.Drops(plane_b_);
  }

  template <class Visitor>
  void ForEachVariable(const Visitor& visit) const {
    visit(plane_a_);
    if (IsBinary()) visit(plane_b_);
    if (NeedsFrame()) visit(pose_);
  }

  /// Whether the frame's pose has columns: the residual turns or shifts with the world.
  bool NeedsFrame() const;

 private:
  PlaneRelationKind kind() const { return relation_.relation.kind; }
  bool IsBinary() const { return !relation_.relation.IsUnary(); }
  int NumRows() const;
  double Sign() const;
  double OffsetDifference(const Vector3d& c_W) const;
  Vector<RelationRows::kMaxRows> WhitenedError() const;
  void SetJacobians(RelationRows& rows) const;
  void SetParallelJacobians(RelationRows& rows) const;
  void SetOffsetJacobians(RelationRows& rows) const;
  void SetFrameJacobian(const Vector3d& r_W, int num_rows, RelationRows& rows) const;

  const WindowRelation& relation_;
  const RelationNoise& noise_;
  Variable plane_a_, plane_b_, pose_;  // of a unary relation plane_b_ is plane_a_
  const WindowPlane& a_;
  const WindowPlane& b_;
  const WindowFrame& frame_;
};

}  // namespace facet
