// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/former_planes.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "facet/geometry/angles.h"

namespace facet {

void FormerPlanes::Add(KnownPlane plane) {
  if (plane.best) planes_.push_back(std::move(plane));
}

bool FormerPlanes::Recall(double max_angle, double max_distance_m, KnownPlane& plane) {
  const Plane& plane_W = plane.estimate.plane_W;
  const Vector3d centre_W = plane.support.Centroid(plane_W);
  auto former = planes_.end();
  double nearest_m = max_distance_m;
  for (auto known = planes_.begin() + static_cast<std::ptrdiff_t>(num_unreachable_);
       known != planes_.end();
       ++known) {
    const Plane& known_W = known->best->plane_W;
    const double distance_m = std::abs(known_W.SignedDistance(centre_W));
    if (distance_m >= nearest_m || AngleBetween(known_W.n, plane_W.n) >= max_angle ||
        !known->support.IsNear(centre_W, kPlaneGrowth_m)) {
      continue;
    }
    nearest_m = distance_m;
    former = known;
  }
  if (former == planes_.end()) return false;
  plane.id = former->id;
  plane.best = former->best;
  plane.first_seen = former->first_seen;
  plane.members.Add(former->members);
  plane.bends = former->bends;
  plane.scatter = former->scatter;
  plane.absorbed = std::move(former->absorbed);
  plane.support.Add(former->support, plane_W);
  planes_.erase(former);
  return true;
}

}  // namespace facet
