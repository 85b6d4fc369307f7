// SPDX-License-Identifier: BSD-2-Clause
// Holds the first frame of a run: its position and its heading, which nothing measures, and widely
// its velocity and biases. Tilt is free (docs/math.md, section 6, (6.3)).
#pragma once

#include "facet/estimator/factors/factor.h"

namespace facet {

/// Needs a window with a start prior, and its frame with motion.
class StartPriorFactor {
 public:
  explicit StartPriorFactor(const SlidingWindow& window);

  /// Whitened: position, heading, velocity, gyro bias, accelerometer bias.
  Vector<13> Error() const;

  double Cost() const { return 0.5 * Error().squaredNorm(); }
  double AddTo(NormalEquations& equations) const;

  /// The first marginalisation takes it up.
  bool IsUsedUp(const MarginalizationPlan&) const { return true; }

  template <class Visitor>
  void ForEachVariable(const Visitor& visit) const {
    visit(Variable::Pose(frame_));
    visit(Variable::Motion(frame_));
  }

 private:
  Vector3d RotationInWorld() const;

  const StartPrior& prior_;
  int frame_;
  const NavState& x_;
};

}  // namespace facet
