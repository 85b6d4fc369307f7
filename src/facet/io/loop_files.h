// SPDX-License-Identifier: BSD-2-Clause
// Trajectories in the map frame, and what was recognised.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "facet/io/trajectory_file.h"
#include "facet/loop/loop_result.h"

namespace facet {

struct OdometryPose {
  StampedPose pose;
  int segment = 0;
};

/// Poses of the odometry moved into the map as it was corrected at the end: corrections of the
/// nodes around a pose are interpolated in time. Beside the first and the last one of a segment
/// they are those of the nearest in it, for worlds before and after a loss may be far from each
/// other; a segment without nodes stays where it is.
std::vector<StampedPose> MoveIntoMap(std::span<const OdometryPose> odometry,
                                     std::span<const MapCorrection> corrections);

/// closures.csv: a line for each comparison of a keyframe with a place.
std::string ClosuresCsv(std::span<const ClosureRecord> closures);

}  // namespace facet
