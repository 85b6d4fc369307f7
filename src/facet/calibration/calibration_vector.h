// SPDX-License-Identifier: BSD-2-Clause
// Everything about the cameras that a calibration says, as one vector of 29 deviations from it
// (docs/math.md, section 10.1).
#pragma once

#include "facet/calibration/rig_parameters.h"

namespace facet {

/// Columns of the calibration: the 22 parameters of lenses and stereo pair (RigVector), then the
/// mount (rotation and translation of both cameras on the body), then the time offset [s].
inline constexpr int kMountRotation = kNumRigParameters;
inline constexpr int kMountTranslation = kMountRotation + 3;
inline constexpr int kTimeOffset = kMountTranslation + 3;
inline constexpr int kNumCalibration = kTimeOffset + 1;
/// Those that move the cameras of a frame as a whole, like its pose.
inline constexpr int kNumMount = kNumCalibration - kNumRigParameters;

using CalibrationVector = Vector<kNumCalibration>;
using CalibrationMatrix = Matrix<kNumCalibration, kNumCalibration>;

/// How far `to` is from `from`, whose models of distortion are the same.
CalibrationVector CalibrationDifference(const StereoRig& from, const StereoRig& to);

}  // namespace facet
