// SPDX-License-Identifier: BSD-2-Clause
// Focal lengths that nobody has calibrated: those of a data sheet, or of another resolution's
// rounding. A gyroscope whose scale is estimated hides them for long (docs/math.md, section 10.11).
#pragma once

#include "facet/calibration/calibration_vector.h"

namespace facet {

/// Both focal lengths 1 % too short, as rough ones are (1-sigma).
CalibrationVector RoughFocalLengths(const StereoRig& rig);

/// `delta` without what both focal lengths have in common.
CalibrationVector WithoutCommonFocalLength(const StereoRig& rig, const CalibrationVector& delta);

/// Whether what was measured says that the focal lengths are rough, and nothing else does as well:
/// not a gyroscope with a wrong scale, nor lenses that do something beside their model. `before`:
/// the information of what was believed; `delta` and `left`: mean and covariance with that belief
/// and all that was measured. The scale of the gyroscope must be estimated.
bool AreFocalLengthsRough(const StereoRig& rig,
                          const CalibrationMatrix& before,
                          const CalibrationVector& delta,
                          const CalibrationMatrix& left);

}  // namespace facet
