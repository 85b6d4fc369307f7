// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/face_claims.h"

#include <algorithm>
#include <cmath>

#include "facet/geometry/angles.h"
#include "facet/regularities/near_points.h"
#include "facet/regularities/plane_gate.h"

namespace facet {

namespace {

// Planes dispute surface where they cross: this near to each other, at an angle between these, and
// facing the same way. The two sides of a door, or wall and cupboard, are parallel and dispute
// nothing.
constexpr double kDispute_m = 0.12;
const double kMaxDisputeCosine = std::cos(3 * kDegree);
const double kMinDisputeCosine = std::cos(25 * kDegree);
// A plane that is farther off by this gives its surface up.
constexpr double kClearlyFarther_m = 0.01;

double DistanceFrom(const KnownPlane& plane, const Vector3d& p_W) {
  return std::abs(plane.estimate.plane_W.SignedDistance(p_W));
}

bool MayDispute(const KnownPlane& a, const KnownPlane& b) {
  const double cosine = a.estimate.plane_W.n.dot(b.estimate.plane_W.n);
  return !a.IsTentative() && !b.IsTentative() && cosine > kMinDisputeCosine &&
         cosine < kMaxDisputeCosine;
}

// Those that may dispute surface with the plane: often none.
std::vector<int> RivalsOf(const KnownPlane& plane, const std::vector<KnownPlane>& planes) {
  std::vector<int> rivals;
  for (std::size_t k = 0; k < planes.size(); ++k) {
    if (MayDispute(plane, planes[k])) rivals.push_back(static_cast<int>(k));
  }
  return rivals;
}

// Largest squared distance of a corner in gates; `limit` or more if it is that far.
double WorstCorner(const SurfaceFaces& faces,
                   const SurfaceFace& face,
                   const Plane& plane,
                   double plane_variance_m2,
                   double limit,
                   const PlaneTrackingOptions& options) {
  double worst = 0;
  for (const int corner : face.corners) {
    const FacePoint& point = faces.points[corner];
    const double variance = point.VarianceAlong(plane.n) + plane_variance_m2;
    const double distance_m = plane.SignedDistance(point.p_W);
    worst = std::max(worst, distance_m * distance_m / SquaredGate(variance, options));
    if (worst >= limit) break;
  }
  return worst;
}

// Where they cross.
bool AreBothNear(const KnownPlane& a, const KnownPlane& b, const Vector3d& p_W) {
  return DistanceFrom(a, p_W) < kDispute_m && DistanceFrom(b, p_W) < kDispute_m;
}

// Known surface of a rival.
bool IsForeign(const std::vector<KnownPlane>& planes,
               const std::vector<int>& rivals,
               const KnownPlane& plane,
               const Vector3d& p_W) {
  return std::any_of(rivals.begin(), rivals.end(), [&](int other) {
    return AreBothNear(planes[other], plane, p_W) && planes[other].support.HasSurface(p_W);
  });
}

}  // namespace

std::vector<int> ClaimFaces(const SurfaceFaces& faces,
                            const std::vector<KnownPlane>& planes,
                            const MapSnapshot& map,
                            const PlaneTrackingOptions& options) {
  const NearPoints centres(faces.faces.size(), [&](std::size_t f) -> const Vector3d& {
    return faces.faces[f].centre_W;
  });
  const Timestamp now = map.latest.t;
  const auto is_active = [&](const KnownPlane& plane) {
    return !plane.IsTentative() && ToSeconds(now - plane.last_seen) <= options.active_s;
  };
  std::vector<int> plane_of_face(faces.faces.size(), -1);
  std::vector<double> best(faces.faces.size(), 1.0);  // as from WorstCorner
  const double min_cosine = std::cos(options.max_face_angle_deg * kDegree);
  for (std::size_t k = 0; k < planes.size(); ++k) {
    const KnownPlane& known = planes[k];
    if (!is_active(known)) continue;
    const Plane& plane = known.estimate.plane_W;
    const DistanceUncertainty uncertainty(known.estimate, map.latest.T_WB);
    std::vector<int> rivals = RivalsOf(known, planes);
    std::erase_if(rivals, [&](int other) { return !is_active(planes[other]); });
    // Its own surface, or so near to it that it may grow, and known to be nobody else's.
    const auto may_have = [&](const Vector3d& p_W) {
      return known.support.HasSurface(p_W) ||
             (known.support.IsNear(p_W, kPlaneGrowth_m) && !IsForeign(planes, rivals, known, p_W));
    };
    centres.ForEachNear(plane, options.max_gate_m, [&](std::size_t f) {
      const SurfaceFace& face = faces.faces[f];
      if (plane.n.dot(face.n_W) < min_cosine) return;
      const double variance =
          uncertainty.VarianceAt(face.centre_W) + kSurfaceFlatness_m * kSurfaceFlatness_m;
      const double worst = WorstCorner(faces, face, plane, variance, best[f], options);
      if (worst >= best[f] || !may_have(face.centre_W)) return;
      best[f] = worst;
      plane_of_face[f] = static_cast<int>(k);
    });
  }
  return plane_of_face;
}

void TakeSurface(const SurfaceFaces& faces,
                 const std::vector<int>& plane_of_face,
                 Timestamp now,
                 std::vector<KnownPlane>& planes) {
  std::vector<std::vector<int>> rivals;
  for (const KnownPlane& plane : planes)
    rivals.push_back(RivalsOf(plane, planes));
  for (std::size_t f = 0; f < faces.faces.size(); ++f) {
    if (plane_of_face[f] < 0 || !faces.faces[f].in_view) continue;
    KnownPlane& plane = planes[plane_of_face[f]];
    const auto& c = faces.faces[f].corners;
    plane.support.AddTriangle(
        {faces.points[c[0]].p_W, faces.points[c[1]].p_W, faces.points[c[2]].p_W});
    plane.last_seen = now;
    const Vector3d& centre_W = faces.faces[f].centre_W;
    const double distance_m = DistanceFrom(plane, centre_W);
    for (const int k : rivals[plane_of_face[f]]) {
      if (AreBothNear(planes[k], plane, centre_W) &&
          DistanceFrom(planes[k], centre_W) > distance_m + kClearlyFarther_m)
        planes[k].support.Remove(centre_W);
    }
  }
}

void LeaveForeignSurface(const MapSnapshot& map,
                         const std::vector<KnownPlane>& planes,
                         PlaneAssignments& out) {
  for (const KnownPlane& plane : planes) {
    if (plane.IsTentative()) continue;
    const std::vector<int> rivals = RivalsOf(plane, planes);
    if (rivals.empty()) continue;
    for (const LandmarkEstimate& landmark : map.landmarks) {
      if (landmark.IsOn(plane.id) && !plane.support.HasSurface(landmark.p_W) &&
          IsForeign(planes, rivals, plane, landmark.p_W))
        out.left.emplace_back(landmark.id, plane.id);
    }
  }
}

}  // namespace facet
