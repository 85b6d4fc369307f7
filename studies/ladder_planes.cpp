// SPDX-License-Identifier: BSD-2-Clause
#include "ladder_planes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "facet/camera/stereo_triangulation.h"

namespace facet {

namespace {

// [1/m] from the left camera, from the two pixels; 0 without a right one.
double StereoInverseDistance(const StereoRig& rig, const FeatureObservation& feature) {
  if (!feature.px_right) return 0;
  const auto left = rig.cameras[0].Unproject(feature.px_left);
  const auto right = rig.cameras[1].BearingOf(*feature.px_right);
  if (!left || !right) return 0;
  const auto found = TriangulateOnRay(*left, *right, rig.T_C1C0());
  return found ? found->inverse_distance : 0;
}

}  // namespace

PlaneAssignments PlaceboPlanes::operator()(const FrameObservations& observations,
                                           const MapSnapshot& snapshot) {
  PlaneAssignments out = oracle_(observations, snapshot);
  for (const NewPlane& plane : out.created)
    planes_.push_back(plane.id);
  for (PlaneAttachment& join : out.attached) {
    const auto own = std::find(planes_.begin(), planes_.end(), join.plane) - planes_.begin();
    join.plane = planes_[static_cast<std::size_t>(own + 1) % planes_.size()];
  }
  return out;
}

PlaneAssignments SpoiledPlanes::operator()(const FrameObservations& observations,
                                           const MapSnapshot& snapshot) {
  constexpr double kDuration_s = 1;
  constexpr std::int64_t kEvery = 5;
  constexpr double kAnyDistance_m = 100;
  PlaneAssignments out = policy_(observations, snapshot);
  if (!first_t_) first_t_ = observations.t;
  const double elapsed_s = ToSeconds(observations.t - *first_t_) - from_s_;
  if (elapsed_s < 0 || elapsed_s > kDuration_s || snapshot.planes.empty()) return out;
  for (const LandmarkEstimate& landmark : snapshot.landmarks) {
    const auto number = static_cast<std::size_t>(landmark.id.value);
    const PlaneId plane = snapshot.planes[number % snapshot.planes.size()].id;
    if (landmark.id.value % kEvery == 0 && !landmark.IsOn(plane))
      out.attached.push_back({landmark.id, plane, kAnyDistance_m});
  }
  return out;
}

// Which plane comes back now, and which one it is taken for.
void WrongReassociation::Begin(const PlaneAssignments& out, const MapSnapshot& snapshot) {
  constexpr double kMinCosine = 0.87;  // 30 deg
  constexpr double kMaxDistance_m = 1;
  const Timestamp now = snapshot.latest.t;
  const auto place_of = [&](LandmarkId id) {
    return std::find_if(snapshot.landmarks.begin(),
                        snapshot.landmarks.end(),
                        [&](const LandmarkEstimate& l) { return l.id == id; });
  };
  for (const PlaneEstimate& back : snapshot.planes) {
    const auto seen = last_seen_.find(back.id);
    if (seen == last_seen_.end() || ToSeconds(now - seen->second) < kAway_s) continue;
    std::vector<Vector3d> points_W;
    for (const PlaneAttachment& join : out.attached) {
      const auto landmark = place_of(join.landmark);
      if (join.plane == back.id && landmark != snapshot.landmarks.end())
        points_W.push_back(landmark->p_W);
    }
    double nearest = kMaxDistance_m * static_cast<double>(points_W.size());
    for (const PlaneEstimate& other : snapshot.planes) {
      if (other.id == back.id || std::abs(other.plane_W.n.dot(back.plane_W.n)) < kMinCosine)
        continue;
      double sum = 0;
      for (const Vector3d& p_W : points_W)
        sum += std::abs(other.plane_W.SignedDistance(p_W));
      if (sum >= nearest) continue;
      nearest = sum;
      neighbour_ = other.id;
      returned_ = back.id;
      began_ = now;
    }
    if (began_) return;
  }
}

PlaneAssignments WrongReassociation::operator()(const FrameObservations& observations,
                                                const MapSnapshot& snapshot) {
  constexpr double kAnyDistance_m = 100;
  PlaneAssignments out = policy_(observations, snapshot);
  if (!began_) {
    Begin(out, snapshot);
    quality_.num_events += began_ ? 1 : 0;
  }
  for (const LandmarkEstimate& landmark : snapshot.landmarks) {
    for (const PlaneId plane : landmark.planes) {
      if (plane.IsValid()) last_seen_[plane] = snapshot.latest.t;
    }
  }
  if (!began_ || ToSeconds(snapshot.latest.t - *began_) > kLasts_s) return out;
  for (PlaneAttachment& join : out.attached) {
    if (join.plane == returned_) join = {join.landmark, neighbour_, kAnyDistance_m};
  }
  return out;
}

OwnSearch::OwnSearch(const SimulatedRun& run,
                     const MeshOptions& mesh,
                     const RegularityOptions& options,
                     Measurements measurements,
                     SearchQuality& quality)
    : run_(run),
      options_(options),
      view_builder_(run.rig, WithSupportPoints(mesh)),
      mesh_(WithSupportPoints(mesh)),
      tracker_(
          options,
          measurements == Measurements::kDetected
              ? PlaneSearch()
              : [this](const SurfaceFaces& faces,
                       const std::vector<char>& taken) { return SeeTrueSurfaces(faces, taken); }),
      quality_(quality) {}

// Which faces lie on a surface is decided as in the search, by the gates on their corners.
std::vector<PlaneCandidate> OwnSearch::SeeTrueSurfaces(const SurfaceFaces& faces,
                                                       std::vector<char> taken) const {
  constexpr double kBeyond_m = 0.1;  // of the surface's edge
  constexpr double kAngle = 0.2 * std::numbers::pi / 180,
                   kOffset_m = 0.003;  // as in plane_candidate.cpp
  std::vector<PlaneCandidate> out;
  for (const Surface& surface : run_.surfaces) {
    PlaneCandidate seen;
    const Vector3d n_W = T_WG_.q * surface.n_W, center_W = T_WG_ * surface.center_W;
    const double side = n_W.dot(faces.camera.p_W - center_W) < 0 ? -1 : 1;
    seen.plane_W.n = side * n_W;
    seen.plane_W.d = seen.plane_W.n.dot(center_W);
    std::vector<int> pool;
    for (int f = 0; f < static_cast<int>(faces.faces.size()); ++f) {
      if (taken[f] != 0 || !faces.faces[f].may_vote) continue;
      const Vector3d p = faces.faces[f].centre_W - center_W;
      if (std::abs(p.dot(T_WG_.q * surface.u_W)) < surface.half_u + kBeyond_m &&
          std::abs(p.dot(T_WG_.q * surface.v_W)) < surface.half_v + kBeyond_m)
        pool.push_back(f);
    }
    seen.faces = FacesOnPlane(faces, pool, seen.plane_W, options_.detection.max_distance_m);
    if (seen.faces.empty()) continue;
    for (const int f : seen.faces) {
      taken[f] = 1;
      seen.area_m2 += faces.faces[f].area_m2;
      seen.centroid_W += faces.faces[f].area_m2 * faces.faces[f].centre_W;
    }
    if (seen.area_m2 <= 0) continue;
    seen.centroid_W /= seen.area_m2;
    seen.normal_covariance =
        kAngle * kAngle * (Matrix3d::Identity() - seen.plane_W.n * seen.plane_W.n.transpose());
    seen.offset_variance_m2 = kOffset_m * kOffset_m;
    seen.orientation = OrientationOf(
        seen.plane_W.n, seen.normal_covariance, options_.detection.max_plane_lean_deg);
    out.push_back(std::move(seen));
  }
  return out;
}

PlaneAssignments OwnSearch::operator()(const FrameObservations& observations,
                                       const MapSnapshot& snapshot) {
  FrontendResult keyframe;
  keyframe.observations = observations;
  std::vector<FeatureObservation>& features = keyframe.observations.features;
  std::sort(features.begin(), features.end(), [](const auto& a, const auto& b) {
    return a.landmark < b.landmark;
  });
  keyframe.depths.intensities.assign(features.size(), 128);
  for (const FeatureObservation& feature : features)
    keyframe.depths.inverse_distances.push_back(StereoInverseDistance(run_.rig, feature));
  const MeshView& view = view_builder_.Build(keyframe, snapshot);
  mesh_.Update(view, snapshot, run_.rig.T_BC[0]);
  SearchMesh searched;
  mesh_.FillSearchMesh(view, searched);
  const auto frame = static_cast<std::size_t>(observations.frame.value);
  T_WG_ = snapshot.latest.T_WB * run_.truth[frame].T_WB.Inverse();
  PlaneAssignments found = tracker_.Process(searched, snapshot).assignments;
  Judge(found);
  return found;
}

void OwnSearch::Judge(const PlaneAssignments& found) {
  quality_.num_created += static_cast<int>(found.created.size());
  for (const PlaneAttachment& join : found.attached) {
    const auto truth = run_.landmarks.find(join.landmark);
    if (truth == run_.landmarks.end()) continue;
    std::map<PlaneId, int>& surfaces = surfaces_of_plane_[join.plane];
    const int count = ++surfaces[truth->second.surface];
    ++quality_.num_joined;
    quality_.num_wrong += std::any_of(
        surfaces.begin(), surfaces.end(), [&](const auto& other) { return other.second > count; });
  }
}

}  // namespace facet
