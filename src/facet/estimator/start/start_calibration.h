// SPDX-License-Identifier: BSD-2-Clause
// The calibration as a variable at the start of a run.
#pragma once

#include "facet/estimator/estimator_options.h"
#include "facet/estimator/window/window_calibration.h"

namespace facet {

/// How uncertain the calibration is before anything was measured: a little more than the rig says
/// (StereoRig::covariance). If it does not say, lenses and stereo pair together as a calibration
/// with a board leaves them, the mount and the clock each for itself. What is held has next to no
/// uncertainty.
CalibrationMatrix StartCovariance(const StereoRig& rig, const CalibrationOptions& options);

}  // namespace facet
