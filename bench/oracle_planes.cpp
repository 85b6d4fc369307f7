// SPDX-License-Identifier: BSD-2-Clause
#include "oracle_planes.h"

#include <vector>

#include "facet/geometry/plane_fit.h"

namespace facet {

void OraclePlanes::EndOld(Timestamp now, PlaneAssignments& out) {
  if (options_.max_age_s <= 0) return;
  std::erase_if(known_, [&](const auto& entry) {
    if (ToSeconds(now - entry.second.since) < options_.max_age_s) return false;
    out.retired.push_back(entry.second.id);
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
      out.attached.push_back({landmark->id, known->second.id});
  }
  return out;
}

}  // namespace facet
