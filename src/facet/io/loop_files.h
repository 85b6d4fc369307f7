// SPDX-License-Identifier: BSD-2-Clause
// Trajectories in the map frame, and what was recognised.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "facet/io/trajectory_file.h"
#include "facet/loop/loop_result.h"

namespace facet {

/// Poses of the odometry moved into the map as it was corrected at the end: corrections of the
/// nodes around a pose are interpolated in time; before the first and after the last one they
/// are those of the nearest.
std::vector<StampedPose> MoveIntoMap(std::span<const StampedPose> odometry,
                                     std::span<const MapCorrection> corrections);

/// closures.csv: a line for each comparison of a keyframe with a place.
std::string ClosuresCsv(std::span<const ClosureRecord> closures);

}  // namespace facet
