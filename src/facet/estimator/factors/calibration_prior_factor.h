// SPDX-License-Identifier: BSD-2-Clause
// What is known of the calibration before anything was measured (docs/math.md, section 10.2).
#pragma once

#include "facet/estimator/factors/factor.h"

namespace facet {

/// Needs a calibration with start information.
class CalibrationPriorFactor {
 public:
  explicit CalibrationPriorFactor(const WindowCalibration& calibration)
      : calibration_(calibration) {}

  double Cost() const {
    const CalibrationVector delta = calibration_.delta() - calibration_.start_mean();
    return 0.5 * delta.dot(*calibration_.start_information * delta);
  }
  double AddTo(NormalEquations& equations) const;

  /// The first marginalisation takes it up.
  bool IsUsedUp(const MarginalizationPlan&) const { return true; }

  template <class Visitor>
  void ForEachVariable(const Visitor& visit) const {
    visit(Variable::Calibration());
  }

 private:
  const WindowCalibration& calibration_;
};

}  // namespace facet
