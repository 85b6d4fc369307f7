// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/factors/prior_factor.h"

namespace facet {

static_assert(Factor<PriorFactor>);

VectorXd PriorDelta(const SlidingWindow& window) {
  VectorXd delta(window.prior.dim());
  for (const MarginalPrior::Block& block : window.prior.blocks) {
    const Variable variable = window.VariableOf(block);
    switch (block.kind) {
      case Variable::Kind::kPlane:
        delta.segment<3>(block.offset) = window.planes[variable.index].delta;
        break;
      case Variable::Kind::kCalibration:
        delta.segment<kNumCalibration>(block.offset) = window.calibration->delta();
        break;
      case Variable::Kind::kPose:
        delta.segment<6>(block.offset) = window.frames[variable.index].delta.head<6>();
        break;
      case Variable::Kind::kMotion:
        delta.segment<9>(block.offset) = window.frames[variable.index].delta.tail<9>();
        break;
    }
  }
  return delta;
}

double PriorFactor::Cost() const {
  const VectorXd delta = PriorDelta(window_);
  const VectorXd H_delta = window_.prior.H * delta;
  return delta.dot(0.5 * H_delta + window_.prior.b);
}

double PriorFactor::AddTo(NormalEquations& equations) const {
  const MarginalPrior& prior = window_.prior;
  const VectorXd delta = PriorDelta(window_);
  const VectorXd H_delta = prior.H * delta;
  const auto column = [&](const MarginalPrior::Block& block) {
    return equations.layout.ColumnOf(window_.VariableOf(block));
  };
  for (const MarginalPrior::Block& r : prior.blocks) {
    const int row = column(r), rows = r.size();
    if (row < 0) continue;
    equations.b.segment(row, rows) +=
        prior.b.segment(r.offset, rows) + H_delta.segment(r.offset, rows);
    for (const MarginalPrior::Block& c : prior.blocks) {
      const int col = column(c), cols = c.size();
      if (col < 0) continue;
      equations.H.block(row, col, rows, cols) += prior.H.block(r.offset, c.offset, rows, cols);
    }
  }
  return delta.dot(0.5 * H_delta + prior.b);
}

}  // namespace facet
