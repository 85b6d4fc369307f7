// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/constrain/support_depths.h"

#include <cmath>

#include "facet/mesh/mesh_view.h"
#include "facet/regularities/track/solved_plane.h"

namespace facet {

namespace {

constexpr double kMinCosine = 0.05;  // between ray and normal
constexpr double kMaxSigmas = 3;     // a point farther from a plane is not on it

struct FusedDepth {
  double scale = 1;
  double square = 0;  // of the sigmas between both depths
};

// Along the ray both depths are normal. Unchanged if the plane explains the depth no better.
void FuseIfNearer(const FacePoint& point,
                  const SolvedPlane& seen,
                  double distance_m,
                  FusedDepth& fused) {
  const Plane& plane = seen.plane_W();
  const double cosine = plane.n.dot(point.ray_W);
  // From behind it is another surface: the far side of a thin wall.
  if (cosine > -kMinCosine) return;
  const double step_m = -plane.SignedDistance(point.p_W) / cosine;
  const Vector3d on_plane_W = point.p_W + step_m * point.ray_W;
  const double own = point.sigma_along_m * point.sigma_along_m;
  const double across = (1 - cosine * cosine) * point.sigma_across_m * point.sigma_across_m;
  const double by_plane =
      (seen.uncertainty.VarianceAt(on_plane_W) + kSurfaceFlatness_m * kSurfaceFlatness_m + across) /
      (cosine * cosine);
  const double square = step_m * step_m / (own + by_plane);
  const double scale = 1 + own / (own + by_plane) * step_m / distance_m;
  if (!(square < fused.square && scale > 0 && seen.tracked->extent.HasSurface(on_plane_W))) return;
  fused = {scale, square};
}

// Returns the scale that the plane asks for which explains the depth best.
double BestScale(const FacePoint& point,
                 const Vector3d& camera_W,
                 const std::vector<SolvedPlane>& seen) {
  const double distance_m = (point.p_W - camera_W).norm();
  FusedDepth best{1, kMaxSigmas * kMaxSigmas};
  for (const SolvedPlane& plane : seen)
    FuseIfNearer(point, plane, distance_m, best);
  return best.scale;
}

}  // namespace

std::vector<double> SupportDepthScales(const SearchMesh& mesh,
                                       const SurfaceFaces& faces,
                                       const std::vector<TrackedPlane>& planes,
                                       const SE3& T_WB) {
  const std::vector<SolvedPlane> seen = SolvedPlanes(planes, T_WB);
  std::vector<char> is_in_view(faces.points.size(), 0);
  for (const SurfaceFace& face : faces.faces) {
    for (const int corner : face.corners)
      if (face.in_view) is_in_view[corner] = 1;
  }
  std::vector<double> scales(faces.points.size(), 1.0);
  for (std::size_t i = 0; i < faces.points.size(); ++i) {
    if (is_in_view[i] == 0 || !IsSupport(mesh.vertex_ids[i])) continue;
    scales[i] = BestScale(faces.points[i], faces.camera.p_W, seen);
  }
  return scales;
}

}  // namespace facet
