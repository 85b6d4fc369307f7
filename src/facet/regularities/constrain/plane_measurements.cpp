// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/constrain/plane_measurements.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "facet/geometry/angles.h"
#include "facet/geometry/plane_fit.h"
#include "facet/regularities/detect/common_error.h"
#include "facet/regularities/track/plane_gate.h"

namespace facet {

namespace {

constexpr double kMaxChiSquare = 2;  // mean over the points; more is not one plane
constexpr int kMinPoints = 8;        // fewer points do not show whether they lie on one plane
// Points known worse than this across the plane, and measurements of a slope worse than this, add
// next to nothing.
constexpr double kMaxPointSigma_m = 0.05, kMaxSlopeSigma = 5 * kDegree;

// A point farther off than this is not on a plane, however uncertain the plane is.
constexpr double kMaxDistance_m = 0.15;

// Which planes the faces around each matched point are on.
class PlanesAround {
 public:
  PlanesAround(const SurfaceFaces& faces, const std::vector<int>& plane_index_of_face)
      : planes_(faces.points.size(), kNone) {
    for (std::size_t f = 0; f < faces.faces.size(); ++f) {
      if (plane_index_of_face[f] < 0 || !faces.faces[f].in_view) continue;
      for (const int corner : faces.faces[f].corners) {
        int& plane = planes_[corner];
        plane =
            plane == kNone || plane == plane_index_of_face[f] ? plane_index_of_face[f] : kSeveral;
      }
    }
  }

  bool AreOthersThan(int plane, std::size_t point) const {
    return planes_[point] >= 0 && planes_[point] != plane;
  }

 private:
  static constexpr int kNone = -1, kSeveral = -2;
  std::vector<int> planes_;
};

struct PointRange {
  std::size_t begin, end;
};

// Vertices are sorted by id.
PointRange MatchedPoints(const SearchMesh& mesh) {
  const auto place = [&](LandmarkId id) {
    const auto at = std::lower_bound(mesh.vertex_ids.begin(), mesh.vertex_ids.end(), id);
    return static_cast<std::size_t>(at - mesh.vertex_ids.begin());
  };
  return {place(mesh.first_match), place(mesh.end_match)};
}

struct WeightedPoints {
  std::vector<Vector3d> p_W;
  std::vector<double> weights;
};

WeightedPoints PointsOn(const TrackedPlane& plane,
                        int index,
                        const SurfaceFaces& faces,
                        const PointRange& matched,
                        const PlanesAround& around,
                        const SE3& T_WB) {
  WeightedPoints out;
  const Plane& plane_W = plane.estimate.plane_W;
  const DistanceUncertainty uncertainty(plane.estimate, T_WB);
  for (std::size_t i = matched.begin; i < matched.end; ++i) {
    const FacePoint& point = faces.points[i];
    const double distance_m = std::abs(plane_W.SignedDistance(point.p_W));
    if (!(distance_m <= kMaxDistance_m) || around.AreOthersThan(index, i)) continue;
    const double variance = point.VarianceFromSurface(plane_W.n);
    if (!(variance <= kMaxPointSigma_m * kMaxPointSigma_m)) continue;
    const double gate = 3 * std::sqrt(variance + uncertainty.VarianceAt(point.p_W));
    if (distance_m > gate || !plane.extent.HasSurface(point.p_W)) continue;
    out.p_W.push_back(point.p_W);
    out.weights.push_back(1 / variance);
  }
  return out;
}

std::optional<PlaneMeasurement> Measure(const WeightedPoints& points,
                                        double unevenness_m,
                                        const FaceCamera& camera,
                                        const SE3& T_WB,
                                        const PlaneMeasurementOptions& options) {
  const auto& [p_W, weights] = points;
  if (static_cast<int>(p_W.size()) < kMinPoints) return std::nullopt;
  const PlaneFit fit = FitPlane(p_W, weights);
  const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
  const double chi_square = fit.thickness_m * fit.thickness_m * total;
  if (chi_square > kMaxChiSquare * static_cast<double>(p_W.size())) return std::nullopt;

  // Equation (9.1).
  const double point_sigma_m = std::sqrt(static_cast<double>(p_W.size()) / total);
  // What the surface rises above the plane here, all points see alike.
  const double sigma_m = std::hypot(
      options.sigma_scale / std::sqrt(total), options.common_share * point_sigma_m, unevenness_m);
  const CommonError common = CommonErrorOf(fit.plane, fit.centroid, camera);
  const auto slope_sigma = [&](double extent_m) {
    return std::hypot(sigma_m / extent_m, common.slope_rad);
  };
  PlaneMeasurement measured;
  const Quaterniond q_BW = T_WB.q.conjugate();
  measured.centre_B = q_BW * (fit.centroid - T_WB.p);
  measured.along_B = {q_BW * fit.major_W, q_BW * fit.plane.n.cross(fit.major_W)};
  measured.sigma_m = std::hypot(sigma_m, common.offset_m);
  measured.sigma_rad = {slope_sigma(fit.extent_major_m), slope_sigma(fit.extent_minor_m)};
  if (!(measured.sigma_rad[1] <= kMaxSlopeSigma)) return std::nullopt;
  return measured;
}

}  // namespace

std::vector<PlaneMeasurement> MeasurePlanes(const SearchMesh& mesh,
                                            const SurfaceFaces& faces,
                                            const std::vector<int>& plane_index_of_face,
                                            const std::vector<TrackedPlane>& planes,
                                            const MapSnapshot& map,
                                            const PlaneMeasurementOptions& options) {
  std::vector<PlaneMeasurement> measurements;
  const PointRange matched = MatchedPoints(mesh);
  if (map.keyframes.empty() || matched.end < matched.begin + kMinPoints) return measurements;
  const PlanesAround around(faces, plane_index_of_face);
  for (std::size_t k = 0; k < planes.size(); ++k) {
    const TrackedPlane& plane = planes[k];
    if (plane.IsTentative() || plane.seen.last < mesh.t) continue;
    const WeightedPoints points =
        PointsOn(plane, static_cast<int>(k), faces, matched, around, map.latest.T_WB);
    std::optional<PlaneMeasurement> measured =
        Measure(points, plane.fit.unevenness.sigma_m(), faces.camera, map.latest.T_WB, options);
    if (!measured) continue;
    measured->frame = map.keyframes.back().id;
    measured->plane = plane.id;
    measurements.push_back(*measured);
  }
  return measurements;
}

}  // namespace facet
