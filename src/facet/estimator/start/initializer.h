// SPDX-License-Identifier: BSD-2-Clause
// Start at rest or in motion: first values of tilt, velocity and gyro bias from a few stereo frames
// and the IMU between them (docs/math.md, section 6). It supplies values only, no information.
#pragma once

#include <string>

#include "facet/estimator/solver/window_solver.h"

namespace facet {

struct InitializationResult {
  bool ok = false;
  std::string reason;  ///< why not
};

/// The window holds consecutive frames with IMU links between them (biases zero or better) and
/// landmarks with depth from stereo. Sets all poses, velocities and biases, with gravity along -z;
/// position and heading of the first frame stay. On failure the window's states are undefined.
InitializationResult InitializeFromStereo(const StereoRig& rig,
                                          const EstimatorOptions& options,
                                          SlidingWindow& window);

}  // namespace facet
