// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/track/retired_planes.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "facet/geometry/angles.h"

namespace facet {

void RetiredPlanes::Add(TrackedPlane plane) {
  if (!plane.best) return;
  plane.state = PlaneState::kRetired;
  planes_.push_back(std::move(plane));
}

std::optional<PlaneId> RetiredPlanes::Reidentify(double max_angle,
                                                 double max_distance_m,
                                                 TrackedPlane& plane) {
  const Plane& plane_W = plane.estimate.plane_W;
  const Vector3d centre_W = plane.extent.Centroid(plane_W);
  auto same = planes_.end();
  double nearest_m = max_distance_m;
  for (auto retired = planes_.begin() + static_cast<std::ptrdiff_t>(num_unreachable_);
       retired != planes_.end();
       ++retired) {
    const Plane& retired_W = retired->best->plane_W;
    const double distance_m = std::abs(retired_W.SignedDistance(centre_W));
    if (distance_m >= nearest_m || AngleBetween(retired_W.n, plane_W.n) >= max_angle ||
        !retired->extent.IsNear(centre_W, kPlaneGrowth_m)) {
      continue;
    }
    nearest_m = distance_m;
    same = retired;
  }
  if (same == planes_.end()) return std::nullopt;
  const PlaneId id = same->id;
  plane.best = same->best;
  plane.seen.first = same->seen.first;
  plane.landmark_count.Add(same->landmark_count);
  plane.fit.curvature = same->fit.curvature;
  plane.fit.scatter = same->fit.scatter;
  plane.merged_ids = std::move(same->merged_ids);
  plane.extent.Add(same->extent, plane_W);
  planes_.erase(same);
  return id;
}

}  // namespace facet
