// SPDX-License-Identifier: BSD-2-Clause
// The calibration is not the same for ever: rigs bend, lenses warm up. What the prior knows of it
// is forgotten a little from time to time, which also bounds what errors of the model can add up
// to.
#pragma once

#include "facet/estimator/window/sliding_window.h"

namespace facet {

bool KnowsCalibration(const MarginalPrior& prior);

/// From here on the calibration is another one, which differs from that of before by a random step
/// with this covariance: the old one is marginalised (docs/math.md, equation (10.6)). Nothing, and
/// false, if the prior does not know the calibration.
bool TakeRandomStep(const CalibrationMatrix& covariance, MarginalPrior& prior);

/// The calibration is with this information as it was given. Nothing, and false, as above.
bool AddInformation(const CalibrationMatrix& information, MarginalPrior& prior);

}  // namespace facet
