// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/factors/calibration_prior_factor.h"

namespace facet {

static_assert(Factor<CalibrationPriorFactor>);

double CalibrationPriorFactor::AddTo(NormalEquations& equations) const {
  const int column = equations.layout.calibration_column;
  if (column < 0) return Cost();
  const CalibrationMatrix& information = *calibration_.start_information;
  equations.H.block<kNumCalibration, kNumCalibration>(column, column) += information;
  equations.b.segment<kNumCalibration>(column) +=
      information * (calibration_.delta() - calibration_.start_mean());
  return Cost();
}

}  // namespace facet
