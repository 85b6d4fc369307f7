// SPDX-License-Identifier: BSD-2-Clause
// The sphere of rays on a plane.
#pragma once

#include "facet/base/types.h"

namespace facet {

/// Where stereographic projection puts a bearing: as the plane z = 1 near the axis, but no
/// direction is stretched away from it, and circles stay circles, so that a triangulation which is
/// Delaunay here is the one of the sphere of rays. Everything but the direction against the axis
/// has a place.
inline Vector2d Stereographic(const Vector3d& bearing) {
  return 2 / (1 + bearing.z()) * bearing.head<2>();
}

}  // namespace facet
