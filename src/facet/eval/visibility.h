// SPDX-License-Identifier: BSD-2-Clause
// Which points of the true surfaces the cameras of a run saw: a mesh can only be blamed for missing
// those.
#pragma once

#include <span>
#include <vector>

#include "facet/camera/stereo_rig.h"
#include "facet/eval/truth_surface.h"
#include "facet/io/trajectory_file.h"

namespace facet {

struct VisibilityOptions {
  double max_distance_m = 5;
  /// Views that differ by less than both from the one before are left out: they see the same.
  double min_step_m = 0.1;
  double min_turn_rad = 0.1;
};

/// Returns for each of surface.points() whether it was seen: inside the image of one of the
/// cameras, not farther away than the limit and not hidden, at one of the true poses. A point is
/// hidden behind a triangle or, if the surface is a cloud, behind a depth image of the cloud (cells
/// of 4 px filled by the points' spacing, 8 cm of tolerance).
std::vector<char> SeenPoints(const TruthSurface& surface,
                             const StereoRig& rig,
                             std::span<const SE3> T_GB,
                             const VisibilityOptions& options = {});

}  // namespace facet
