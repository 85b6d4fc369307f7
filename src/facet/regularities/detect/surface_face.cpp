// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/detect/surface_face.h"

#include <algorithm>

#include "facet/base/check.h"

namespace facet {

namespace {
constexpr double kSigma_px = 0.7;   // of a vertex in the image
constexpr double kNearest_m = 0.1;  // nearer surfaces count as if they were here

// By what a surface at this distance counts more, or less, than its size.
double Magnification(double distance_m) {
  const double nearer = kFullSizeDistance_m / std::max(distance_m, kNearest_m);
  const double length = std::max(nearer, 1.0) / LengthScale(distance_m);
  return length * length;
}
}  // namespace

FacePoint MakeFacePoint(const Vector3d& p_W, double sigma_depth_m, const FaceCamera& camera) {
  FacePoint point;
  point.p_W = p_W;
  const Vector3d ray = p_W - camera.p_W;
  const double distance = ray.norm();
  if (distance > 1e-6) point.ray_W = 1 / distance * ray;
  point.sigma_along_m = sigma_depth_m;
  point.length_scale = LengthScale(distance);
  point.sigma_across_m = camera.sigma_direction * distance;
  return point;
}

// Both lists are sorted by id.
std::vector<int> LandmarksOfVertices(const SearchMesh& mesh, const MapSnapshot& map) {
  std::vector<int> out(mesh.vertex_ids.size(), -1);
  std::size_t l = 0;
  for (std::size_t i = 0; i < mesh.vertex_ids.size(); ++i) {
    while (l < map.landmarks.size() && map.landmarks[l].id < mesh.vertex_ids[i])
      ++l;
    if (l == map.landmarks.size()) break;
    if (map.landmarks[l].id == mesh.vertex_ids[i]) out[i] = static_cast<int>(l);
  }
  return out;
}

void FillSurfaceFaces(const SearchMesh& mesh, SurfaceFaces& out) {
  FACET_CHECK(mesh.vertices.empty() || mesh.focal_px * mesh.baseline_m > 0);
  out.camera = {mesh.T_WC.p,
                kSigma_px / mesh.focal_px,
                kCommonDisparity_px / (mesh.focal_px * mesh.baseline_m)};
  out.points.resize(mesh.vertices.size());
  out.faces.resize(mesh.faces.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    out.points[i] = MakeFacePoint(mesh.vertices[i], mesh.sigma_depth_m[i], out.camera);
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    SurfaceFace& face = out.faces[f];
    face.corners = mesh.faces[f];
    const Vector3d& a = mesh.vertices[face.corners[0]];
    const Vector3d& b = mesh.vertices[face.corners[1]];
    const Vector3d& c = mesh.vertices[face.corners[2]];
    const Vector3d n = (b - a).cross(c - a);
    const double norm = n.norm();
    face.centre_W = 1.0 / 3 * (a + b + c);
    const bool has_area = norm > 1e-12 && std::isfinite(norm);
    face.area_m2 = has_area ? 0.5 * norm : 0;
    const double distance_m = (face.centre_W - mesh.T_WC.p).norm();
    face.search_area_m2 = has_area ? face.area_m2 * Magnification(distance_m) : 0;
    face.length_scale = LengthScale(distance_m);
    face.n_W = has_area ? Vector3d(1 / norm * n) : Vector3d::UnitZ();
    face.may_vote = mesh.may_vote[f] != 0 && has_area;
    face.in_view = mesh.in_view[f] != 0;
  }
}

}  // namespace facet
