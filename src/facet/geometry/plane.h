// SPDX-License-Identifier: BSD-2-Clause
// Infinite planes n . p = d with a unit normal n.
#pragma once

#include <cmath>

#include "facet/geometry/so3.h"

namespace facet {

/// A plane in the world: n . p = d [m].
struct Plane {
  Vector3d n = Vector3d::UnitZ();  ///< unit length
  double d = 0;

  double SignedDistance(const Vector3d& p) const { return n.dot(p) - d; }
};

/// Moves a unit vector along the sphere by `u` [rad], in the two directions of TangentBasis(n).
inline Vector3d RetractDirection(const Vector3d& n, const Vector2d& u) {
  const double angle = u.norm();
  if (angle < 1e-12) return (n + TangentBasis(n) * u).normalized();
  return (std::cos(angle) * n + std::sin(angle) / angle * (TangentBasis(n) * u)).normalized();
}

}  // namespace facet
