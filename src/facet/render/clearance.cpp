// SPDX-License-Identifier: BSD-2-Clause
#include "facet/render/clearance.h"

#include <algorithm>
#include <cstdio>

namespace facet {
namespace {

enum class Place { kFree, kInSolid, kOutside };

/// From inside a solid, or from outside a room, most surfaces around are seen from behind.
Place FindPlace(const SceneMesh& mesh, const RayScene& rays, const Vector3d& p_W) {
  int num_front = 0, num_back = 0;
  for (int i = 0; i < 6; ++i) {
    // Slightly off the axes: edges of boxes and walls are often parallel to them.
    Vector3d direction(0.013, 0.027, 0.041);
    direction(i / 2) = i % 2 ? 1 : -1;
    const auto hit = rays.Cast(p_W, direction);
    if (!hit || mesh.parts[mesh.triangles[hit->triangle].part].is_sheet) continue;
    ++(hit->is_back_face ? num_back : num_front);
  }
  if (num_front + num_back == 0) return Place::kOutside;
  return num_back > num_front ? Place::kInSolid : Place::kFree;
}

std::string Describe(double seconds, const Vector3d& p_W, const std::string& what) {
  char text[256];
  std::snprintf(text,
                sizeof(text),
                "the path at %.2f s (%.2f %.2f %.2f) %s",
                seconds,
                p_W.x(),
                p_W.y(),
                p_W.z(),
                what.c_str());
  return text;
}

}  // namespace

Clearance CheckClearance(const SceneMesh& mesh,
                         const RayScene& rays,
                         const SplineTrajectory& trajectory,
                         Timestamp begin,
                         Timestamp end,
                         double min_distance_m) {
  Clearance result;
  result.min_distance_m = Clearance::kReach_m;
  for (Timestamp t = begin; t <= end; t = t + FromSeconds(0.02)) {
    const Vector3d p_W = trajectory.At(t).state.T_WB.p;
    const double seconds = ToSeconds(t - begin);
    const auto nearest = rays.FindNearest(p_W, result.min_distance_m);
    if (nearest) {
      result.min_distance_m = nearest->distance_m;
      if (nearest->distance_m < min_distance_m) {
        char what[160];
        std::snprintf(what,
                      sizeof(what),
                      "comes within %.2f m of a surface (%.60s); at least %.2f m is needed",
                      nearest->distance_m,
                      mesh.parts[mesh.triangles[nearest->triangle].part].label.c_str(),
                      min_distance_m);
        result.problem = Describe(seconds, p_W, what);
        return result;
      }
    }
    const Place place = FindPlace(mesh, rays, p_W);
    if (place == Place::kFree) continue;
    result.problem = Describe(
        seconds,
        p_W,
        place == Place::kOutside ? "leaves the scene" : "is inside a solid or outside the walls");
    return result;
  }
  return result;
}

}  // namespace facet
