// SPDX-License-Identifier: BSD-2-Clause
// Estimates how far the clock of a trajectory is off that of its ground truth.
#pragma once

#include <span>

#include "facet/eval/trajectory_error.h"

namespace facet {

/// The offset to add to the stamps of the estimate for the least ATE (rmse), within +-max_offset,
/// to a microsecond. Zero when the trajectories never overlap by three poses. Both are sorted.
Duration EstimateTimeOffset(std::span<const StampedPose> estimate,
                            std::span<const StampedPose> truth,
                            AlignmentKind alignment,
                            Duration max_offset = {500'000'000});

std::vector<StampedPose> ShiftInTime(std::span<const StampedPose> poses, Duration offset);

}  // namespace facet
