// SPDX-License-Identifier: BSD-2-Clause
// A corridor that leads around a block and back to where it began, for flights that see the same
// walls again.
#pragma once

#include <vector>

#include "facet/sim/room_scene.h"

namespace facet {

struct CorridorOptions {
  double length_m = 8, depth_m = 5;      ///< of the rectangle along the middle of the corridor
  double width_m = 2.2, height_m = 2.7;  ///< of the corridor
  double heading_rad = 0.4;              ///< of the long sides
  int num_cupboards = 10;                ///< cuboids on the walls, where there is a free place
  double cupboard_depth_m = 0.4;         ///< how far their fronts, parallel to the wall, stand out
};

/// Floor, ceiling, four outer and four inner walls, then the cupboards, which differ for each state
/// of `rng`. surfaces[i].id == PlaneId{i}. The middle of the block is the origin, the floor z = 0.
std::vector<Surface> MakeCorridor(const CorridorOptions& options, Rng& rng);

/// The corners of a walk along the middle of the corridor, `laps` times around.
std::vector<Vector3d> CorridorWalk(const CorridorOptions& options, int laps);

}  // namespace facet
