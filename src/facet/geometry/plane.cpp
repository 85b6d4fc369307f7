// SPDX-License-Identifier: BSD-2-Clause
#include "facet/geometry/plane.h"

#include <cmath>

#include "facet/geometry/so3.h"

namespace facet {

Vector3d RetractDirection(const Vector3d& n, const Vector2d& u) {
  const double angle = u.norm();
  if (angle < 1e-12) return (n + TangentBasis(n) * u).normalized();
  return (std::cos(angle) * n + std::sin(angle) / angle * (TangentBasis(n) * u)).normalized();
}

}  // namespace facet
