// SPDX-License-Identifier: BSD-2-Clause
#include "facet/render/path_box.h"

#include <limits>

#include "facet/geometry/so3.h"

namespace facet {

PathBox BoundPath(std::span<const Vector3d> path_W, double yaw_rad) {
  PathBox box;
  box.T_WF.q = ExpSO3(Vector3d(0, 0, yaw_rad));
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Vector3d low = Vector3d::Constant(kInfinity), high = -low;
  for (const Vector3d& p_W : path_W) {
    const Vector3d p = box.T_WF.q.conjugate() * p_W;
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  // Built-in flights leave more room below them than recorded ones that begin on the ground.
  const double floor_z = low.z() > 0.45 && low.z() < 2 ? 0 : low.z() - 0.5;
  const Vector3d middle = 0.5 * (low + high);
  box.T_WF.p = box.T_WF.q * Vector3d(middle.x(), middle.y(), floor_z);
  box.size = high - low;
  box.size.z() = high.z() - floor_z;
  return box;
}

}  // namespace facet
