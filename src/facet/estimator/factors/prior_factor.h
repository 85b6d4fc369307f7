// SPDX-License-Identifier: BSD-2-Clause
// What marginalisation has left: a quadratic on the frozen variables (docs/math.md, section 5.1).
#pragma once

#include "facet/estimator/factors/factor.h"

namespace facet {

/// How far the variables of the prior have moved since they entered it.
VectorXd PriorDelta(const SlidingWindow& window);

/// Needs a window with a prior.
class PriorFactor {
 public:
  explicit PriorFactor(const SlidingWindow& window) : window_(window) {}

  double Cost() const;
  double AddTo(NormalEquations& equations) const;

  /// Every marginalisation makes a new prior of the old one.
  bool IsUsedUp(const MarginalizationPlan&) const { return true; }

  template <class Visitor>
  void ForEachVariable(const Visitor& visit) const {
    for (const MarginalPrior::Block& block : window_.prior.blocks)
      visit(window_.VariableOf(block));
  }

 private:
  const SlidingWindow& window_;
};

}  // namespace facet
