// SPDX-License-Identifier: BSD-2-Clause
// Lenses and a stereo pair that nobody has calibrated with care: glued by eye, knocked since then,
// with another lens's distortion, or with numbers of the left camera in the place of the right one
// (docs/math.md, section 10.11).
#pragma once

#include <vector>

#include "facet/calibration/calibration_vector.h"

namespace facet {

/// Ways in which they are wrong then, each by as much as it is (1-sigma): focal length and
/// principal point of either camera, its coefficients of distortion, and the turn of the cameras
/// against each other. Not the distance between them: the size of the world would rest on the
/// accelerometer alone.
std::vector<CalibrationVector> RoughLensErrors(const StereoRig& rig);

/// Those of them that are no distortion.
std::vector<CalibrationVector> RoughPlaceErrors(const StereoRig& rig);

/// Whether what was measured says that one of them is there. `before`: the information of what was
/// believed; `delta` and `left`: mean and covariance with that belief and all that was measured.
bool AreLensesRough(const StereoRig& rig,
                    const CalibrationMatrix& before,
                    const CalibrationVector& delta,
                    const CalibrationMatrix& left);

}  // namespace facet
