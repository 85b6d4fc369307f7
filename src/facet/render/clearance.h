// SPDX-License-Identifier: BSD-2-Clause
// Whether a path stays inside the scene and away from its surfaces.
#pragma once

#include <string>

#include "facet/render/ray_scene.h"
#include "facet/sim/spline_trajectory.h"

namespace facet {

struct Clearance {
  double min_distance_m = 0;  ///< smallest distance on the path, at most `kReach_m`
  std::string problem;        ///< where and what, in words; empty: the path is fine
  static constexpr double kReach_m = 2;
};

/// Looks every 20 ms between `begin` and `end`.
Clearance CheckClearance(const SceneMesh& mesh,
                         const RayScene& rays,
                         const SplineTrajectory& trajectory,
                         Timestamp begin,
                         Timestamp end,
                         double min_distance_m);

}  // namespace facet
