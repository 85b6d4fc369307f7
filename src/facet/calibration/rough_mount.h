// SPDX-License-Identifier: BSD-2-Clause
// Cameras on an IMU that nobody has calibrated with care: mounted by eye, with numbers from a
// drawing (docs/math.md, section 10.11).
#pragma once

#include <optional>
#include <vector>

#include "facet/calibration/error_evidence.h"

namespace facet {

/// Ways in which they are wrong then, each by as much as it is (1-sigma): a turn about each axis,
/// and a shift along each.
std::vector<CalibrationVector> RoughMountErrors();

/// What the calibration is if the mount may be that wrong; empty unless what was measured says so,
/// also when all other errors of a rough rig may be there. `before`: the information of
/// what was believed; `delta` and `left`: mean and covariance with that belief and all that was
/// measured.
std::optional<FreedEstimate> FindRoughMount(const StereoRig& rig,
                                            const CalibrationMatrix& before,
                                            const CalibrationVector& delta,
                                            const CalibrationMatrix& left);

}  // namespace facet
