// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/plane_tracker.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "facet/geometry/angles.h"
#include "facet/geometry/plane_fit.h"
#include "facet/regularities/constrain/plane_measurements.h"
#include "facet/regularities/constrain/support_depths.h"
#include "facet/regularities/constrain/triangle_verdicts.h"
#include "facet/regularities/report/plane_label.h"
#include "facet/regularities/report/plane_records.h"
#include "facet/regularities/track/face_assignment.h"
#include "facet/regularities/track/landmark_attachment.h"
#include "facet/regularities/track/plane_gate.h"
#include "facet/regularities/track/plane_merge.h"
#include "facet/regularities/track/plane_misfit.h"

namespace facet {

namespace {

// Landmarks known worse than this across a new plane do not count.
constexpr double kMaxLandmarkSigma_m = 0.1;
// A detection whose normal is known worse (1-sigma, both directions together) could be any plane
// that crosses there: nothing is associated with it.
constexpr double kMaxDetectionSigma = 2.5 * kDegree;
// How far along the plane a detection may be from the plane's extent.
constexpr double kMaxGap_m = 2.5;

}  // namespace

RegularityResult PlaneTracker::Process(const SearchMesh& mesh, const MapSnapshot& map) {
  RegularityResult result;
  PlaneAssignments& out = result.assignments;
  now_ = mesh.t;
  FillSurfaceFaces(mesh, faces_);
  landmark_of_point_ = LandmarksOfVertices(mesh, map);
  TakeEstimates(map, out);
  if (options_.tracking.revise) Revise(map, out);
  plane_index_of_face_ = AssignFaces(faces_, planes_, map, options_);
  Detect(map);
  Confirm(out);
  AttachLandmarks(map, faces_, landmark_of_point_, plane_index_of_face_, planes_, out);
  ExtendPlanes(faces_, plane_index_of_face_, now_, planes_);
  DetachFromForeignSurface(map, planes_, out);
  if (options_.measurements.enabled) {
    out.measurements =
        MeasurePlanes(mesh, faces_, plane_index_of_face_, planes_, map, options_.measurements);
  }
  Relate(out);
  result.mesh = JudgeMesh(mesh, map.latest.T_WB);
  return result;
}

// The estimator has the last word on its planes, and what it dropped is retired.
void PlaneTracker::TakeEstimates(const MapSnapshot& map, PlaneAssignments& out) {
  for (std::size_t k = planes_.size(); k-- > 0;) {
    TrackedPlane& plane = planes_[k];
    plane.detections.offset_m = 0;
    if (plane.IsTentative()) {
      if (ToSeconds(now_ - plane.seen.last) > options_.tracking.active_s)
        planes_.erase(planes_.begin() + static_cast<std::ptrdiff_t>(k));
      continue;
    }
    const auto estimate = std::find_if(map.planes.begin(),
                                       map.planes.end(),
                                       [&](const PlaneEstimate& e) { return e.id == plane.id; });
    if (estimate == map.planes.end()) {
      Retire(k);
      continue;
    }
    plane.Update(*estimate);
    plane.landmark_count.Update(map.landmarks, plane.id);
    plane.UpdateOrientation(options_.detection.max_plane_lean_deg);
    const double max_age = options_.tracking.max_age_s;
    if (max_age > 0 && ToSeconds(now_ - plane.confirmed_at) >= max_age) {
      out.retired.push_back(plane.id);
      Retire(k);
    }
  }
}

void PlaneTracker::Retire(std::size_t plane) {
  relations_.Forget(planes_[plane].id);
  retired_.Add(std::move(planes_[plane]));
  planes_.erase(planes_.begin() + static_cast<std::ptrdiff_t>(plane));
}

// Planes of the estimator that turned out to be none, or the same as another.
void PlaneTracker::Revise(const MapSnapshot& map, PlaneAssignments& out) {
  RemoveMisfits(map, faces_.camera, planes_, out);
  MergeSameSurfaces(map, planes_, out);
  for (const PlaneId plane : out.retired)
    relations_.Forget(plane);
}

// Among the faces that belong to no plane yet.
void PlaneTracker::Detect(const MapSnapshot& map) {
  std::vector<char> taken(plane_index_of_face_.size());
  std::transform(
      plane_index_of_face_.begin(), plane_index_of_face_.end(), taken.begin(), [](int plane) {
        return plane >= 0 ? 1 : 0;
      });
  const std::vector<PlaneCandidate> candidates =
      find_ ? find_(faces_, taken) : detector_.Detect(faces_, taken);
  for (const PlaneCandidate& candidate : candidates)
    Associate(map, candidate);
}

// With a plane of the estimator, with a tentative plane, or with none: then it is a new one.
void PlaneTracker::Associate(const MapSnapshot& map, const PlaneCandidate& candidate) {
  int plane = FindConfirmed(map, candidate);
  if (plane >= 0) {
    if (candidate.normal_covariance.trace() > kMaxDetectionSigma * kMaxDetectionSigma) return;
    planes_[plane].detections.offset_m =
        std::abs(planes_[plane].estimate.plane_W.SignedDistance(candidate.centroid_W));
  } else {
    if (IsNearConfirmed(candidate)) return;
    plane = FindTentative(candidate);
    if (plane < 0) {
      plane = static_cast<int>(planes_.size());
      planes_.emplace_back(candidate, now_);
    }
    TrackedPlane& tentative = planes_[plane];
    tentative.estimate.plane_W = candidate.plane_W;
    tentative.orientation = candidate.orientation;
    if (tentative.detections.num == 0 || tentative.seen.last < now_) ++tentative.detections.num;
    tentative.seen.last = now_;
  }
  for (const int f : candidate.faces)
    plane_index_of_face_[f] = plane;
}

// The nearest by the joint covariance of plane and pose, -1: none is within the gate.
int PlaneTracker::FindConfirmed(const MapSnapshot& map, const PlaneCandidate& candidate) const {
  int found = -1;
  double best = options_.tracking.max_chi_square;
  for (std::size_t k = 0; k < planes_.size(); ++k) {
    const TrackedPlane& plane = planes_[k];
    if (plane.IsTentative() || plane.estimate.covariance(9, 9) <= 0 ||
        AngleBetween(plane.estimate.plane_W.n, candidate.plane_W.n) > 2 * kSamePlaneAngle ||
        !plane.extent.IsNear(candidate.centroid_W, candidate.length_scale * kMaxGap_m)) {
      continue;
    }
    const double chi_square = ChiSquare(candidate, plane.estimate, map.latest.T_WB);
    if (chi_square >= best) continue;
    best = chi_square;
    found = static_cast<int>(k);
  }
  return found;
}

int PlaneTracker::FindTentative(const PlaneCandidate& candidate) const {
  int found = -1;
  double best = candidate.length_scale * options_.detection.max_distance_m;
  for (std::size_t k = 0; k < planes_.size(); ++k) {
    const TrackedPlane& plane = planes_[k];
    if (!plane.IsTentative() ||
        AngleBetween(plane.estimate.plane_W.n, candidate.plane_W.n) > kSamePlaneAngle ||
        !plane.extent.IsNear(candidate.centroid_W, candidate.length_scale * kMaxGap_m)) {
      continue;
    }
    const double distance = std::abs(plane.estimate.plane_W.SignedDistance(candidate.centroid_W));
    if (distance >= best) continue;
    best = distance;
    found = static_cast<int>(k);
  }
  return found;
}

// Neither the confirmed plane nor clearly another one.
bool PlaneTracker::IsNearConfirmed(const PlaneCandidate& candidate) const {
  const double max_distance_m = candidate.length_scale * options_.detection.max_distance_m;
  return std::any_of(planes_.begin(), planes_.end(), [&](const TrackedPlane& tracked) {
    const Plane& plane = tracked.estimate.plane_W;
    return !tracked.IsTentative() && AngleBetween(plane.n, candidate.plane_W.n) < kSamePlaneAngle &&
           std::abs(plane.SignedDistance(candidate.centroid_W)) < max_distance_m &&
           tracked.extent.IsNear(candidate.centroid_W, candidate.length_scale * kPlaneGrowth_m);
  });
}

// The detector searches the newest view only; landmarks on faces of earlier views count as well.
void PlaneTracker::AddFacesOfEarlierViews(int plane) {
  const TrackedPlane& tentative = planes_[plane];
  std::vector<int> free;
  for (std::size_t f = 0; f < faces_.faces.size(); ++f) {
    const SurfaceFace& face = faces_.faces[f];
    if (plane_index_of_face_[f] < 0 && face.may_vote && !face.in_view)
      free.push_back(static_cast<int>(f));
  }
  const double max_distance_m = options_.detection.max_distance_m;
  for (const int f : FacesOnPlane(faces_, free, tentative.estimate.plane_W, max_distance_m)) {
    const SurfaceFace& face = faces_.faces[f];
    if (face.n_W.dot(tentative.estimate.plane_W.n) > 0 &&
        tentative.extent.IsNear(face.centre_W, face.length_scale * kPlaneGrowth_m))
      plane_index_of_face_[f] = plane;
  }
}

void PlaneTracker::ReleaseFacesOfEarlierViews(int plane) {
  for (std::size_t f = 0; f < faces_.faces.size(); ++f) {
    if (plane_index_of_face_[f] == plane && !faces_.faces[f].in_view) plane_index_of_face_[f] = -1;
  }
}

// Enough of them, and spread so that they determine the normal: a plane variable that is poorly
// determined would follow whatever is measured first.
bool PlaneTracker::HasEnoughLandmarks(int plane) const {
  const PlaneTrackingOptions& limits = options_.tracking;
  const Vector3d& n_W = planes_[plane].estimate.plane_W.n;
  std::vector<int> on_plane, corners;
  for (std::size_t f = 0; f < faces_.faces.size(); ++f) {
    if (plane_index_of_face_[f] != plane) continue;
    on_plane.push_back(static_cast<int>(f));
    for (const int corner : faces_.faces[f].corners) {
      const FacePoint& point = faces_.points[corner];
      if (landmark_of_point_[corner] >= 0 &&
          point.SigmaAlong(n_W) < point.length_scale * kMaxLandmarkSigma_m)
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
    weights.push_back(1 / faces_.points[corner].VarianceFromSurface(n_W));
  }
  const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
  const double extent_m = FitPlane(points, weights).extent_minor_m;
  const double sigma_normal = 1 / (std::sqrt(total) * extent_m);
  // Few are enough if they are far apart: walls with little texture have no more.
  const bool are_spread = sigma_normal <= limits.max_spread_sigma_deg * kDegree;
  const int needed = are_spread ? fewest : limits.min_landmarks;
  return num >= needed && extent_m >= MinExtent_m(faces_, on_plane, options_.detection) &&
         sigma_normal <= limits.max_normal_sigma_deg * kDegree;
}

// Tentative planes that were detected often enough become variables of the estimator.
void PlaneTracker::Confirm(PlaneAssignments& out) {
  for (std::size_t k = 0; k < planes_.size(); ++k) {
    TrackedPlane& plane = planes_[k];
    if (!plane.IsTentative() || plane.seen.last < now_ ||
        plane.detections.num < options_.tracking.min_detections) {
      continue;
    }
    if (options_.detection.only_in_view) AddFacesOfEarlierViews(static_cast<int>(k));
    if (!HasEnoughLandmarks(static_cast<int>(k))) {
      ReleaseFacesOfEarlierViews(static_cast<int>(k));  // another plane may need them
      continue;
    }
    const Vector3d centroid_W = plane.extent.Centroid(plane.estimate.plane_W);
    std::optional<PlaneId> id;
    if (MayReidentify()) {
      const double length_scale = LengthScale((centroid_W - faces_.camera.p_W).norm());
      id = retired_.Reidentify(
          kSamePlaneAngle, length_scale * options_.detection.max_distance_m, plane);
    }
    plane.Confirm(id ? *id : PlaneId{next_id_++}, now_);
    out.created.push_back({plane.id, plane.estimate.plane_W, centroid_W});
  }
}

void PlaneTracker::Relate(PlaneAssignments& out) {
  std::vector<RelatedPlane> planes;
  for (const TrackedPlane& plane : planes_) {
    if (!plane.IsTentative() && plane.confirmed_at < now_)
      planes.push_back({&plane.estimate,
                        plane.orientation,
                        plane.extent.area_m2(),
                        plane.extent.Centroid(plane.estimate.plane_W)});
  }
  relations_.Update(planes, out.relations);
}

std::vector<int> PlaneTracker::FacePlaneIds() const {
  std::vector<int> out(faces_.faces.size(), -1);
  for (std::size_t f = 0; f < out.size(); ++f) {
    const int plane = plane_index_of_face_[f];
    if (plane >= 0 && !planes_[plane].IsTentative())
      out[f] = static_cast<int>(planes_[plane].id.value);
  }
  return out;
}

// As the triangles are shown once planes have moved the support points that lie on them.
std::vector<TriangleVerdict> PlaneTracker::JudgeShownTriangles(
    const SearchMesh& mesh, const std::vector<double>& depth_scales, const SE3& T_WB) const {
  std::vector<FacePoint> points;
  points.reserve(mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Vector3d shown_W =
        depth_scales.empty() ? mesh.shown_vertices[i] : mesh.ShownWith(depth_scales[i], i);
    points.push_back(MakeFacePoint(shown_W, mesh.sigma_depth_m[i], faces_.camera));
  }
  return JudgeTriangles(points, mesh.triangles, planes_, T_WB, options_);
}

MeshRegularities PlaneTracker::JudgeMesh(const SearchMesh& mesh, const SE3& T_WB) const {
  MeshRegularities out;
  out.face_plane_ids = FacePlaneIds();
  if (options_.support_depths.enabled)
    out.depth_scales = SupportDepthScales(mesh, faces_, planes_, T_WB);
  if (options_.faces.enabled && !mesh.triangles.empty())
    out.verdicts = JudgeShownTriangles(mesh, out.depth_scales, T_WB);
  return out;
}

void PlaneTracker::Reset() {
  for (TrackedPlane& plane : planes_)
    retired_.Add(std::move(plane));
  retired_.StartOver();
  planes_.clear();
  relations_.Clear();
}

std::vector<PlaneRecord> PlaneTracker::Records() const {
  std::vector<TrackedPlane> planes(retired_.reachable().begin(), retired_.reachable().end());
  planes.insert(planes.end(), planes_.begin(), planes_.end());
  std::vector<PlaneRecord> records = MakeRecords(retired_.unreachable(), false);
  const std::vector<PlaneRecord> newer = MakeRecords(planes, MayReidentify());
  records.insert(records.end(), newer.begin(), newer.end());  // ids go on across resets
  LabelPlanes(records);
  return records;
}

}  // namespace facet
