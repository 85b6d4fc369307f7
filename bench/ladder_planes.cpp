// SPDX-License-Identifier: BSD-2-Clause
#include "ladder_planes.h"

#include <algorithm>

#include "facet/geometry/plane_fit.h"

namespace facet {

void OraclePlanes::EndOld(Timestamp now, PlaneAssignments& out) {
  if (options_.max_age_s <= 0) return;
  std::erase_if(known_, [&](const auto& entry) {
    if (ToSeconds(now - entry.second.since) < options_.max_age_s) return false;
    out.ended.push_back(entry.second.id);
    return true;
  });
}

PlaneAssignments OraclePlanes::operator()(const FrameObservations& /*observations*/,
                                          const MapSnapshot& snapshot) {
  PlaneAssignments out;
  const Timestamp now = snapshot.latest.t;
  // A surface whose plane just ended starts anew one keyframe later.
  const auto known_before = known_;
  EndOld(now, out);
  std::map<PlaneId, std::vector<const LandmarkEstimate*>> by_surface;
  for (const LandmarkEstimate& landmark : snapshot.landmarks) {
    const auto truth = run_.landmarks.find(landmark.id);
    if (truth != run_.landmarks.end()) by_surface[truth->second.surface].push_back(&landmark);
  }
  for (const auto& [surface, landmarks] : by_surface) {
    auto known = known_.find(surface);
    if (known == known_.end()) {
      if (known_before.contains(surface)) continue;
      if (static_cast<int>(landmarks.size()) < options_.min_landmarks) continue;
      std::vector<Vector3d> points_W;
      for (const LandmarkEstimate* landmark : landmarks)
        points_W.push_back(landmark->p_W);
      const PlaneFit fit = FitPlane(points_W);
      if (fit.extent_minor_m < options_.min_extent_m) continue;
      known = known_.emplace(surface, Known{PlaneId{next_id_++}, now}).first;
      out.created.push_back({known->second.id, fit.plane, fit.centroid});
    }
    for (const LandmarkEstimate* landmark : landmarks)
      out.joined.push_back({landmark->id, known->second.id});
  }
  return out;
}

PlaneAssignments PlaceboPlanes::operator()(const FrameObservations& observations,
                                           const MapSnapshot& snapshot) {
  PlaneAssignments out = oracle_(observations, snapshot);
  for (const NewPlane& plane : out.created)
    planes_.push_back(plane.id);
  for (PlaneJoin& join : out.joined) {
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
      out.joined.push_back({landmark.id, plane, kAnyDistance_m});
  }
  return out;
}

OwnSearch::OwnSearch(const SimulatedRun& run,
                     const MeshOptions& mesh,
                     const RegularityOptions& options,
                     SearchQuality& quality)
    : run_(run), mesh_(run.rig, mesh), tracker_(options), quality_(quality) {}

PlaneAssignments OwnSearch::operator()(const FrameObservations& observations,
                                       const MapSnapshot& snapshot) {
  FrameObservations sorted = observations;
  std::sort(sorted.features.begin(), sorted.features.end(), [](const auto& a, const auto& b) {
    return a.landmark < b.landmark;
  });
  MeshPacket images;
  images.intensities.assign(sorted.features.size(), 128);
  const auto mesh = mesh_.Process(sorted, images, snapshot);
  PlaneAssignments found = tracker_.Process(*mesh, snapshot);
  Judge(found);
  return found;
}

void OwnSearch::Judge(const PlaneAssignments& found) {
  quality_.num_created += static_cast<int>(found.created.size());
  for (const PlaneJoin& join : found.joined) {
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
