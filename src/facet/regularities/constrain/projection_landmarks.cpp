// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/constrain/projection_landmarks.h"

#include <algorithm>

namespace facet {

PlaneAssignments ProjectionLandmarks::Process(const SearchMesh& mesh, const MapSnapshot& map) {
  FillSurfaceFaces(mesh, faces_);
  std::vector<char> on_plane(faces_.faces.size(), 0);
  for (const PlaneCandidate& candidate : detector_.Detect(faces_, on_plane)) {
    for (const int f : candidate.faces)
      on_plane[f] = 1;
  }
  enum : char { kNoFace, kOffPlane, kOnPlane };
  std::vector<char> place(map.landmarks.size(), kNoFace);
  const std::vector<int> landmarks = LandmarksOfVertices(mesh, map);
  for (std::size_t f = 0; f < faces_.faces.size(); ++f) {
    if (only_in_view_ && !faces_.faces[f].in_view) continue;  // not searched
    for (const int corner : faces_.faces[f].corners) {
      if (landmarks[corner] < 0) continue;
      char& here = place[landmarks[corner]];
      here = std::max<char>(here, on_plane[f] != 0 ? kOnPlane : kOffPlane);
    }
  }
  PlaneAssignments out;
  std::set<LandmarkId> kept;  // what the estimator forgot goes
  for (std::size_t l = 0; l < map.landmarks.size(); ++l) {
    const LandmarkId id = map.landmarks[l].id;
    const bool was = projected_.contains(id);
    if (place[l] == kOnPlane && !was) out.projected.push_back(id);
    if (place[l] == kOffPlane && was) out.unprojected.push_back(id);
    if (place[l] == kOnPlane || (was && place[l] == kNoFace)) kept.insert(id);
  }
  projected_ = std::move(kept);
  return out;
}

}  // namespace facet
