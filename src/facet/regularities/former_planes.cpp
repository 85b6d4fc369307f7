// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/former_planes.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace facet {

namespace {
constexpr double kMaxGap_m = 0.5;
}  // namespace

void FormerPlanes::Add(KnownPlane plane) {
  if (plane.best) planes_.push_back(std::move(plane));
}

bool FormerPlanes::Recall(double max_angle, double max_distance_m, KnownPlane& plane) {
  const Plane& plane_W = plane.estimate.plane_W;
  const Vector3d centre_W = plane.support.Centroid(plane_W);
  const auto first = planes_.begin() + static_cast<std::ptrdiff_t>(num_unreachable_);
  const auto former = std::find_if(first, planes_.end(), [&](const KnownPlane& known) {
    const Plane& known_W = known.best->plane_W;
    return std::abs(known_W.n.dot(plane_W.n)) > std::cos(max_angle) &&
           std::abs(known_W.SignedDistance(centre_W)) < max_distance_m &&
           known.support.IsNear(centre_W, kMaxGap_m);
  });
  if (former == planes_.end()) return false;
  plane.id = former->id;
  plane.best = former->best;
  plane.first_seen = former->first_seen;
  plane.num_landmarks += former->num_landmarks;
  plane.absorbed = std::move(former->absorbed);
  plane.support.Add(former->support, plane_W);
  planes_.erase(former);
  return true;
}

}  // namespace facet
