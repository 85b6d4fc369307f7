// SPDX-License-Identifier: BSD-2-Clause
// Infinite planes n . p = d with a unit normal n.
#pragma once

#include "facet/base/types.h"

namespace facet {

/// A plane in the world: n . p = d [m].
struct Plane {
  Vector3d n{0, 0, 1};  ///< unit length
  double d = 0;

  double SignedDistance(const Vector3d& p) const { return n.dot(p) - d; }
};

/// Moves a unit vector along the sphere by `u` [rad], in the two directions of TangentBasis(n).
Vector3d RetractDirection(const Vector3d& n, const Vector2d& u);

}  // namespace facet
