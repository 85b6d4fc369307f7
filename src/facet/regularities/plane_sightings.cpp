// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/plane_sightings.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>

#include "facet/geometry/plane_fit.h"

namespace facet {

namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kFlatness_m = 0.005;  // of real surfaces, 1-sigma
constexpr double kMaxChiSquare = 2;    // mean over the points: more is not one plane

using PlaneAndPoint = std::pair<int, int>;

// The corners of the planes' newest faces that are no landmarks, by plane.
std::vector<PlaneAndPoint> FreePoints(const SurfaceFaces& faces,
                                      std::span<const int> plane_of_face,
                                      std::span<const int> landmark_of_point,
                                      std::span<const KnownPlane> planes) {
  std::vector<PlaneAndPoint> points;
  for (std::size_t f = 0; f < faces.faces.size(); ++f) {
    const int plane = plane_of_face[f];
    if (plane < 0 || !faces.faces[f].in_view || planes[plane].IsTentative()) continue;
    for (const int corner : faces.faces[f].corners) {
      if (landmark_of_point[corner] < 0) points.emplace_back(plane, corner);
    }
  }
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  return points;
}

std::optional<PlaneSighting> Sight(const SurfaceFaces& faces,
                                   std::span<const PlaneAndPoint> points,
                                   const Plane& known_W,
                                   const SE3& T_WB,
                                   const SightingOptions& options) {
  std::vector<Vector3d> p_W;
  std::vector<double> weights;
  for (const auto& [plane, i] : points) {
    const FacePoint& point = faces.points[i];
    const double sigma = point.SigmaAlong(known_W.n);
    if (!(sigma <= options.max_point_sigma_m)) continue;
    p_W.push_back(point.p_W);
    weights.push_back(1 / (sigma * sigma + kFlatness_m * kFlatness_m));
  }
  if (static_cast<int>(p_W.size()) < options.min_points) return std::nullopt;
  const PlaneFit fit = FitPlane(p_W, weights);
  const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
  const double chi_square = fit.thickness_m * fit.thickness_m * total;
  if (chi_square > kMaxChiSquare * static_cast<double>(p_W.size())) return std::nullopt;

  // Equation (9.1).
  const double sigma_m = options.sigma_scale / std::sqrt(total);
  const auto slope_sigma = [&](double extent_m) {
    return std::hypot(sigma_m / extent_m, options.min_sigma_deg * kDegree);
  };
  PlaneSighting sighting;
  const Quaterniond q_BW = T_WB.q.conjugate();
  sighting.centre_B = q_BW * (fit.centroid - T_WB.p);
  sighting.along_B = {q_BW * fit.major_W, q_BW * fit.plane.n.cross(fit.major_W)};
  sighting.sigma_m = std::hypot(sigma_m, options.min_sigma_m);
  sighting.sigma_rad = {slope_sigma(fit.extent_major_m), slope_sigma(fit.extent_minor_m)};
  if (!(sighting.sigma_rad[1] <= options.max_sigma_deg * kDegree)) return std::nullopt;
  return sighting;
}

}  // namespace

std::vector<PlaneSighting> SightPlanes(const SurfaceFaces& faces,
                                       std::span<const int> plane_of_face,
                                       std::span<const int> landmark_of_point,
                                       std::span<const KnownPlane> planes,
                                       const MapSnapshot& map,
                                       const SightingOptions& options) {
  std::vector<PlaneSighting> sightings;
  if (map.keyframes.empty()) return sightings;
  const std::vector<PlaneAndPoint> points =
      FreePoints(faces, plane_of_face, landmark_of_point, planes);
  for (std::size_t i = 0; i < points.size();) {
    std::size_t end = i;
    while (end < points.size() && points[end].first == points[i].first)
      ++end;
    const KnownPlane& plane = planes[points[i].first];
    std::optional<PlaneSighting> sighting = Sight(faces,
                                                  std::span(points).subspan(i, end - i),
                                                  plane.estimate.plane_W,
                                                  map.latest.T_WB,
                                                  options);
    i = end;
    if (!sighting) continue;
    sighting->frame = map.keyframes.back().id;
    sighting->plane = plane.id;
    sightings.push_back(*sighting);
  }
  return sightings;
}

}  // namespace facet
