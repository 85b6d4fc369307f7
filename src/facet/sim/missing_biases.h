// SPDX-License-Identifier: BSD-2-Clause
// Biases of an IMU for recorded ground truth that does not tell them.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "facet/imu/imu_types.h"

namespace facet {

/// Replaces biases that are nan. Where some states have one, the others get that of the state
/// before (the first ones that of the first that has). Where none has, all get a constant: what the
/// samples are more than the path through the poses explains. The accelerometer's is solved for
/// together with the record's vertical, which may be off by some tenths of a degree; the two are
/// told apart by the turns of the body and by what is usual (0.2 and 0.05 m/s^2).
/// Returns the constants; a part that was recorded is nan. Empty: nothing was missing everywhere.
/// Samples that no pose is near do not count. CHECKs like SplineTrajectory::Fit.
std::optional<ImuBias> FillInBiases(std::span<const ImuSample> imu, std::vector<NavState>& states);

}  // namespace facet
