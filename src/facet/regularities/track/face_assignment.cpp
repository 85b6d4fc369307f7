// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/track/face_assignment.h"

#include <algorithm>
#include <cmath>

#include "facet/geometry/angles.h"
#include "facet/regularities/detect/near_points.h"
#include "facet/regularities/track/plane_gate.h"

namespace facet {

namespace {

// Two planes cross if they are this near to each other, at an angle between these, and face the
// same way. The two sides of a door, or a wall and a cupboard, are parallel: they do not compete
// for surface.
constexpr double kCrossing_m = 0.12;
const double kMaxCrossingCosine = std::cos(3 * kDegree);
const double kMinCrossingCosine = std::cos(kMaxFaceAngle);
// A plane that is farther from a face by this gives up the surface there.
constexpr double kClearlyFarther_m = 0.01;

double DistanceFrom(const TrackedPlane& plane, const Vector3d& p_W) {
  return std::abs(plane.estimate.plane_W.SignedDistance(p_W));
}

bool MayCross(const TrackedPlane& a, const TrackedPlane& b) {
  const double cosine = a.estimate.plane_W.n.dot(b.estimate.plane_W.n);
  return !a.IsTentative() && !b.IsTentative() && cosine > kMinCrossingCosine &&
         cosine < kMaxCrossingCosine;
}

// The planes that may cross this one: often none.
std::vector<int> RivalsOf(const TrackedPlane& plane, const std::vector<TrackedPlane>& planes) {
  std::vector<int> rivals;
  for (std::size_t k = 0; k < planes.size(); ++k) {
    if (MayCross(plane, planes[k])) rivals.push_back(static_cast<int>(k));
  }
  return rivals;
}

// Largest squared distance of a corner in gates; `limit` or more if it is that far.
double WorstCorner(const SurfaceFaces& faces,
                   const SurfaceFace& face,
                   const Plane& plane,
                   double plane_variance_m2,
                   double limit,
                   double max_distance_m) {
  double worst = 0;
  for (const int corner : face.corners) {
    const FacePoint& point = faces.points[corner];
    const double distance_m = plane.SignedDistance(point.p_W);
    // Beyond the widest gate: most corners, at a fraction of the cost.
    if (std::abs(distance_m) > point.length_scale * max_distance_m) return limit;
    const double variance = point.VarianceAlong(plane.n) + plane_variance_m2;
    const double gate = SquaredGate(variance, max_distance_m, point.length_scale);
    if (!(distance_m * distance_m < limit * gate)) return limit;
    worst = std::max(worst, distance_m * distance_m / gate);
  }
  return worst;
}

// Whether the planes cross at this point.
bool AreBothNear(const TrackedPlane& a, const TrackedPlane& b, const Vector3d& p_W) {
  return DistanceFrom(a, p_W) < kCrossing_m && DistanceFrom(b, p_W) < kCrossing_m;
}

// Whether the point belongs to the extent of a plane that crosses there.
bool IsForeign(const std::vector<TrackedPlane>& planes,
               const std::vector<int>& rivals,
               const TrackedPlane& plane,
               const Vector3d& p_W) {
  return std::any_of(rivals.begin(), rivals.end(), [&](int other) {
    return AreBothNear(planes[other], plane, p_W) && planes[other].extent.HasSurface(p_W);
  });
}

}  // namespace

std::vector<int> AssignFaces(const SurfaceFaces& faces,
                             const std::vector<TrackedPlane>& planes,
                             const MapSnapshot& map,
                             const RegularityOptions& options) {
  const NearPoints centres(faces.faces.size(), [&](std::size_t f) -> const Vector3d& {
    return faces.faces[f].centre_W;
  });
  const Timestamp now = map.latest.t;
  const double max_distance_m = options.detection.max_distance_m;
  double max_scale = 1;
  for (const SurfaceFace& face : faces.faces)
    max_scale = std::max(max_scale, face.length_scale);
  const auto is_active = [&](const TrackedPlane& plane) {
    return !plane.IsTentative() && !plane.IsDormant(now, options.tracking.active_s);
  };
  std::vector<int> plane_index_of_face(faces.faces.size(), -1);
  std::vector<double> best(faces.faces.size(), 1.0);  // as from WorstCorner
  const double min_cosine = std::cos(kMaxFaceAngle);
  for (std::size_t k = 0; k < planes.size(); ++k) {
    const TrackedPlane& tracked = planes[k];
    if (!is_active(tracked)) continue;
    const Plane& plane = tracked.estimate.plane_W;
    const DistanceUncertainty uncertainty(tracked.estimate, map.latest.T_WB);
    std::vector<int> rivals = RivalsOf(tracked, planes);
    std::erase_if(rivals, [&](int other) { return !is_active(planes[other]); });
    // Inside the plane's extent, or near enough to grow there if it is no other plane's.
    const auto may_have = [&](const SurfaceFace& face) {
      const Vector3d& p_W = face.centre_W;
      const double growth_m = face.length_scale * kPlaneGrowth_m;
      return tracked.extent.HasSurface(p_W) ||
             (tracked.extent.IsNear(p_W, growth_m) && !IsForeign(planes, rivals, tracked, p_W));
    };
    centres.ForEachNear(plane, max_scale * max_distance_m, [&](std::size_t f) {
      const SurfaceFace& face = faces.faces[f];
      if (plane.n.dot(face.n_W) < min_cosine) return;
      const double flatness_m = face.length_scale * kSurfaceFlatness_m;
      const double variance = uncertainty.VarianceAt(face.centre_W) + flatness_m * flatness_m;
      const double worst = WorstCorner(faces, face, plane, variance, best[f], max_distance_m);
      if (worst >= best[f] || !may_have(face)) return;
      best[f] = worst;
      plane_index_of_face[f] = static_cast<int>(k);
    });
  }
  return plane_index_of_face;
}

void ExtendPlanes(const SurfaceFaces& faces,
                  const std::vector<int>& plane_index_of_face,
                  Timestamp now,
                  std::vector<TrackedPlane>& planes) {
  std::vector<std::vector<int>> rivals;
  for (const TrackedPlane& plane : planes)
    rivals.push_back(RivalsOf(plane, planes));
  for (std::size_t f = 0; f < faces.faces.size(); ++f) {
    if (plane_index_of_face[f] < 0 || !faces.faces[f].in_view) continue;
    TrackedPlane& plane = planes[plane_index_of_face[f]];
    const auto& c = faces.faces[f].corners;
    plane.extent.AddTriangle(
        {faces.points[c[0]].p_W, faces.points[c[1]].p_W, faces.points[c[2]].p_W});
    plane.seen.last = now;
    const Vector3d& centre_W = faces.faces[f].centre_W;
    const double distance_m = DistanceFrom(plane, centre_W);
    for (const int k : rivals[plane_index_of_face[f]]) {
      if (AreBothNear(planes[k], plane, centre_W) &&
          DistanceFrom(planes[k], centre_W) > distance_m + kClearlyFarther_m)
        planes[k].extent.Remove(centre_W);
    }
  }
}

void DetachFromForeignSurface(const MapSnapshot& map,
                              const std::vector<TrackedPlane>& planes,
                              PlaneAssignments& out) {
  for (const TrackedPlane& plane : planes) {
    if (plane.IsTentative()) continue;
    const std::vector<int> rivals = RivalsOf(plane, planes);
    if (rivals.empty()) continue;
    for (const LandmarkEstimate& landmark : map.landmarks) {
      if (landmark.IsOn(plane.id) && !plane.extent.HasSurface(landmark.p_W) &&
          IsForeign(planes, rivals, plane, landmark.p_W))
        out.detached.emplace_back(landmark.id, plane.id);
    }
  }
}

}  // namespace facet
