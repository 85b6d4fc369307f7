// SPDX-License-Identifier: BSD-2-Clause
// Where a path leaves room for a scene.
#pragma once

#include <span>

#include "facet/geometry/se3.h"

namespace facet {

/// An upright box.
struct PathBox {
  SE3 T_WF;       ///< middle of the floor; x and y along the sides
  Vector3d size;  ///< from the floor to the highest point of the path
};

/// The box around a path, turned by `yaw_rad`. The floor is at z = 0 below a built-in flight, and
/// half a metre below the lowest point of a recorded one, which may begin on the ground.
PathBox BoundPath(std::span<const Vector3d> path_W, double yaw_rad);

}  // namespace facet
