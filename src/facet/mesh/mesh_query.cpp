// SPDX-License-Identifier: BSD-2-Clause
#include "facet/mesh/mesh_query.h"

#include <cmath>

namespace facet {

std::optional<SurfaceHit> MeshQuery::FirstAlongRay(const Vector3d& origin_W,
                                                   const Vector3d& direction_W,
                                                   double max_distance_m) const {
  const double length = direction_W.norm();
  if (!origin_W.allFinite() || !std::isfinite(length) || !(length > 0)) return std::nullopt;
  const Vector3d unit_W = direction_W / length;
  SurfaceHit first;
  index_.VisitLine(origin_W, unit_W, 0, max_distance_m, [&](int face, double t) {
    if (first.face < 0 || t < first.distance_m || (t == first.distance_m && face < first.face))
      first = {origin_W + t * unit_W, t, face};
    return true;
  });
  if (first.face < 0) return std::nullopt;
  return first;
}

std::optional<SurfaceHit> MeshQuery::Below(const Vector3d& p_W, double max_height_m) const {
  return FirstAlongRay(p_W, -Vector3d::UnitZ(), max_height_m);
}

std::optional<SurfaceHit> MeshQuery::Nearest(const Vector3d& p_W, double max_distance_m) const {
  if (!p_W.allFinite() || !(max_distance_m >= 0)) return std::nullopt;
  const auto found = index_.Closest(p_W, max_distance_m);
  if (!found) return std::nullopt;
  return SurfaceHit{found->p, found->distance, found->face};
}

}  // namespace facet
