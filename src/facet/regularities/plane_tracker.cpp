// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/plane_tracker.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "facet/geometry/angles.h"
#include "facet/geometry/plane_fit.h"
#include "facet/regularities/face_claims.h"
#include "facet/regularities/face_judge.h"
#include "facet/regularities/landmark_joining.h"
#include "facet/regularities/plane_gate.h"
#include "facet/regularities/plane_label.h"
#include "facet/regularities/plane_merge.h"
#include "facet/regularities/plane_misfit.h"
#include "facet/regularities/plane_records.h"
#include "facet/regularities/plane_sightings.h"
#include "facet/regularities/support_depths.h"

namespace facet {

namespace {

constexpr double kSameAngle = 5 * kDegree;
constexpr double kTentativeLife_s = 1.5;
constexpr double kMaxLandmarkSigma_m = 0.1;

}  // namespace

RegularityResult PlaneTracker::Process(const SearchMesh& mesh, const MapSnapshot& map) {
  RegularityResult result;
  PlaneAssignments& out = result.assignments;
  now_ = mesh.t;
  FillSurfaceFaces(mesh, faces_);
  landmark_of_point_ = LandmarksOfVertices(mesh, map);
  Refresh(map, out);
  if (options_.tracking.revise) {
    EndMisfits(map, faces_.camera.sigma_direction, options_.tracking, planes_, out);
    MergeSameSurfaces(map, planes_, out);
    for (const PlaneId plane : out.ended)
      relations_.Forget(plane);
  }
  plane_of_face_ = ClaimFaces(faces_, planes_, map, options_.tracking);
  std::vector<char> taken(plane_of_face_.size());
  std::transform(plane_of_face_.begin(), plane_of_face_.end(), taken.begin(), [](int plane) {
    return plane >= 0 ? 1 : 0;
  });
  const std::vector<PlaneCandidate> seen =
      find_ ? find_(faces_, taken) : detector_.Detect(faces_, taken);
  for (const PlaneCandidate& candidate : seen)
    Recognise(map, candidate);
  Promote(out);
  JoinLandmarks(map, faces_, landmark_of_point_, plane_of_face_, planes_, out);
  TakeSurface(faces_, plane_of_face_, now_, planes_);
  LeaveForeignSurface(map, planes_, out);
  if (options_.sightings.enabled)
    out.sighted = SightPlanes(mesh, faces_, plane_of_face_, planes_, map, options_.sightings);
  Relate(out);
  result.mesh = JudgeMesh(mesh, map.latest.T_WB);
  return result;
}

// The estimator's values are the truth about its planes, and what it dropped is gone.
void PlaneTracker::Refresh(const MapSnapshot& map, PlaneAssignments& out) {
  for (std::size_t k = planes_.size(); k-- > 0;) {
    KnownPlane& plane = planes_[k];
    plane.recognised_at_m = 0;
    if (plane.IsTentative()) {
      if (ToSeconds(now_ - plane.last_seen) > kTentativeLife_s)
        planes_.erase(planes_.begin() + static_cast<std::ptrdiff_t>(k));
      continue;
    }
    const auto estimate = std::find_if(map.planes.begin(),
                                       map.planes.end(),
                                       [&](const PlaneEstimate& e) { return e.id == plane.id; });
    if (estimate == map.planes.end()) {
      Forget(k);
      continue;
    }
    plane.Update(*estimate);
    plane.members.Update(map.landmarks, plane.id);
    plane.SetOrientation(options_.detection.max_plane_lean_deg);
    const double max_age = options_.tracking.max_age_s;
    if (max_age > 0 && ToSeconds(now_ - *plane.handed_over) >= max_age) {
      out.ended.push_back(plane.id);
      Forget(k);
    }
  }
}

void PlaneTracker::Forget(std::size_t plane) {
  relations_.Forget(planes_[plane].id);
  former_.Add(std::move(planes_[plane]));
  planes_.erase(planes_.begin() + static_cast<std::ptrdiff_t>(plane));
}

int PlaneTracker::FindKnown(const MapSnapshot& map, const PlaneCandidate& candidate) const {
  int found = -1;
  double best = options_.tracking.max_chi_square;
  for (std::size_t k = 0; k < planes_.size(); ++k) {
    const KnownPlane& known = planes_[k];
    if (known.IsTentative() || known.estimate.covariance(9, 9) <= 0 ||
        AngleBetween(known.estimate.plane_W.n, candidate.plane_W.n) > 2 * kSameAngle ||
        !known.support.IsNear(candidate.centroid_W, options_.tracking.max_gap_m)) {
      continue;
    }
    const double chi_square = ChiSquare(candidate, known.estimate, map.latest.T_WB);
    if (chi_square >= best) continue;
    best = chi_square;
    found = static_cast<int>(k);
  }
  return found;
}

int PlaneTracker::FindTentative(const PlaneCandidate& candidate) const {
  int found = -1;
  double best = options_.tracking.min_separation_m;
  for (std::size_t k = 0; k < planes_.size(); ++k) {
    const KnownPlane& known = planes_[k];
    if (!known.IsTentative() ||
        AngleBetween(known.estimate.plane_W.n, candidate.plane_W.n) > kSameAngle ||
        !known.support.IsNear(candidate.centroid_W, options_.tracking.max_gap_m)) {
      continue;
    }
    const double distance = std::abs(known.estimate.plane_W.SignedDistance(candidate.centroid_W));
    if (distance >= best) continue;
    best = distance;
    found = static_cast<int>(k);
  }
  return found;
}

// Neither the known plane nor clearly another one.
bool PlaneTracker::IsNearKnown(const PlaneCandidate& candidate) const {
  return std::any_of(planes_.begin(), planes_.end(), [&](const KnownPlane& known) {
    const Plane& plane = known.estimate.plane_W;
    return !known.IsTentative() && AngleBetween(plane.n, candidate.plane_W.n) < kSameAngle &&
           std::abs(plane.SignedDistance(candidate.centroid_W)) <
               options_.tracking.min_separation_m &&
           known.support.IsNear(candidate.centroid_W, kPlaneGrowth_m);
  });
}

void PlaneTracker::Recognise(const MapSnapshot& map, const PlaneCandidate& candidate) {
  int plane = FindKnown(map, candidate);
  if (plane >= 0) {
    const double max_sigma = options_.tracking.max_sighting_sigma_deg * kDegree;
    if (candidate.normal_covariance.trace() > max_sigma * max_sigma) return;
    planes_[plane].recognised_at_m =
        std::abs(planes_[plane].estimate.plane_W.SignedDistance(candidate.centroid_W));
  } else {
    if (IsNearKnown(candidate)) return;
    plane = FindTentative(candidate);
    if (plane < 0) {
      plane = static_cast<int>(planes_.size());
      planes_.emplace_back(candidate, now_);
    }
    KnownPlane& tentative = planes_[plane];
    tentative.estimate.plane_W = candidate.plane_W;
    tentative.orientation = candidate.orientation;
    if (tentative.times_seen == 0 || tentative.last_seen < now_) ++tentative.times_seen;
    tentative.last_seen = now_;
  }
  for (const int f : candidate.faces)
    plane_of_face_[f] = plane;
}

// Faces of earlier views that the search has left out; their landmarks count as well.
void PlaneTracker::AddOldFaces(int plane) {
  const KnownPlane& tentative = planes_[plane];
  std::vector<int> free;
  for (std::size_t f = 0; f < faces_.faces.size(); ++f) {
    const SurfaceFace& face = faces_.faces[f];
    if (plane_of_face_[f] < 0 && face.may_vote && !face.in_view)
      free.push_back(static_cast<int>(f));
  }
  const double max_distance_m = options_.detection.max_distance_m;
  for (const int f : FacesOnPlane(faces_, free, tentative.estimate.plane_W, max_distance_m)) {
    const SurfaceFace& face = faces_.faces[f];
    if (face.n_W.dot(tentative.estimate.plane_W.n) > 0 &&
        tentative.support.IsNear(face.centre_W, kPlaneGrowth_m))
      plane_of_face_[f] = plane;
  }
}

void PlaneTracker::GiveUpOldFaces(int plane) {
  for (std::size_t f = 0; f < faces_.faces.size(); ++f) {
    if (plane_of_face_[f] == plane && !faces_.faces[f].in_view) plane_of_face_[f] = -1;
  }
}

// Enough of them, and spread so that they determine the normal: once a plane is a variable it
// should be known, not follow whatever comes first.
bool PlaneTracker::HasEnoughLandmarks(int plane) const {
  const PlaneTrackingOptions& limits = options_.tracking;
  const Vector3d& n_W = planes_[plane].estimate.plane_W.n;
  std::vector<int> corners;
  for (std::size_t f = 0; f < faces_.faces.size(); ++f) {
    if (plane_of_face_[f] != plane) continue;
    for (const int corner : faces_.faces[f].corners) {
      if (landmark_of_point_[corner] >= 0 &&
          faces_.points[corner].SigmaAlong(n_W) < kMaxLandmarkSigma_m)
        corners.push_back(corner);
    }
  }
  std::sort(corners.begin(), corners.end());
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  const int num = static_cast<int>(corners.size());
  const int fewest = std::min(limits.min_landmarks, limits.min_spread_landmarks);
  if (num < fewest) return false;
  std::vector<Vector3d> points;
  std::vector<double> weights;
  for (const int corner : corners) {
    points.push_back(faces_.points[corner].p_W);
    weights.push_back(
        1 / (faces_.points[corner].VarianceAlong(n_W) + kSurfaceFlatness_m * kSurfaceFlatness_m));
  }
  const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
  const double extent_m = FitPlane(points, weights).extent_minor_m;
  const double sigma_normal = 1 / (std::sqrt(total) * extent_m);
  // Few are enough if they are far apart: walls with hardly any texture have no more.
  const bool are_spread = sigma_normal <= limits.max_spread_sigma_deg * kDegree;
  const int needed = are_spread ? fewest : limits.min_landmarks;
  return num >= needed && extent_m >= limits.min_landmark_extent_m &&
         sigma_normal <= limits.max_normal_sigma_deg * kDegree;
}

void PlaneTracker::Promote(PlaneAssignments& out) {
  for (std::size_t k = 0; k < planes_.size(); ++k) {
    KnownPlane& plane = planes_[k];
    if (!plane.IsTentative() || plane.last_seen < now_ ||
        plane.times_seen < options_.tracking.min_sightings) {
      continue;
    }
    if (options_.detection.only_in_view) AddOldFaces(static_cast<int>(k));
    if (!HasEnoughLandmarks(static_cast<int>(k))) {
      GiveUpOldFaces(static_cast<int>(k));  // another plane may need them
      continue;
    }
    if (!MayRecall() || !former_.Recall(kSameAngle, options_.tracking.min_separation_m, plane))
      plane.id = PlaneId{next_id_++};
    plane.estimate.id = plane.id;
    plane.handed_over = now_;
    out.created.push_back(
        {plane.id, plane.estimate.plane_W, plane.support.Centroid(plane.estimate.plane_W)});
  }
}

void PlaneTracker::Relate(PlaneAssignments& out) {
  std::vector<RelatedPlane> planes;
  for (const KnownPlane& plane : planes_) {
    if (!plane.IsTentative() && plane.handed_over < now_)
      planes.push_back({&plane.estimate,
                        plane.orientation,
                        plane.support.area_m2(),
                        plane.support.Centroid(plane.estimate.plane_W)});
  }
  relations_.Update(planes, out.related);
}

std::vector<int> PlaneTracker::FacePlanes() const {
  std::vector<int> out(faces_.faces.size(), -1);
  for (std::size_t f = 0; f < out.size(); ++f) {
    const int plane = plane_of_face_[f];
    if (plane >= 0 && !planes_[plane].IsTentative())
      out[f] = static_cast<int>(planes_[plane].id.value);
  }
  return out;
}

// As the triangles are shown once planes have moved the support points that lie on them.
std::vector<TriangleVerdict> PlaneTracker::JudgeTriangles(const SearchMesh& mesh,
                                                          const std::vector<double>& depth_scales,
                                                          const SE3& T_WB) const {
  std::vector<FacePoint> points;
  points.reserve(mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Vector3d shown_W =
        depth_scales.empty() ? mesh.shown_vertices[i] : mesh.ShownWith(depth_scales[i], i);
    points.push_back(MakeFacePoint(shown_W, mesh.sigma_depth_m[i], faces_.camera));
  }
  return JudgeFaces(points, mesh.triangles, planes_, T_WB, options_);
}

MeshRegularities PlaneTracker::JudgeMesh(const SearchMesh& mesh, const SE3& T_WB) const {
  MeshRegularities out;
  out.face_planes = FacePlanes();
  if (options_.support_depths.enabled)
    out.depth_scales = SupportDepthScales(mesh, faces_, planes_, T_WB, options_.support_depths);
  if (options_.faces.enabled && !mesh.triangles.empty())
    out.verdicts = JudgeTriangles(mesh, out.depth_scales, T_WB);
  return out;
}

void PlaneTracker::Reset() {
  for (KnownPlane& plane : planes_)
    former_.Add(std::move(plane));
  former_.StartOver();
  planes_.clear();
  relations_.Clear();
}

std::vector<PlaneRecord> PlaneTracker::Records() const {
  std::vector<KnownPlane> planes(former_.reachable().begin(), former_.reachable().end());
  planes.insert(planes.end(), planes_.begin(), planes_.end());
  std::vector<PlaneRecord> records = MakeRecords(former_.unreachable(), false);
  const std::vector<PlaneRecord> newer = MakeRecords(planes, MayRecall());
  records.insert(records.end(), newer.begin(), newer.end());  // ids go on across resets
  LabelPlanes(records);
  return records;
}

}  // namespace facet
