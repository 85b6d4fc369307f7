// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/track/landmark_attachment.h"

#include <algorithm>
#include <utility>

namespace facet {

namespace {

// Points are sorted by id, and support points, which are no landmarks, come last.
int EndOfLandmarks(const std::vector<int>& landmark_of_point) {
  const auto last = std::find_if(landmark_of_point.rbegin(),
                                 landmark_of_point.rend(),
                                 [](int landmark) { return landmark >= 0; });
  return static_cast<int>(last.base() - landmark_of_point.begin());
}

}  // namespace

void AttachLandmarks(const MapSnapshot& map,
                     const SurfaceFaces& faces,
                     const std::vector<int>& landmark_of_point,
                     const std::vector<int>& plane_index_of_face,
                     const std::vector<TrackedPlane>& planes,
                     PlaneAssignments& out) {
  std::vector<int> faces_around(map.landmarks.size(), 0);
  std::vector<std::pair<int, int>> on_planes;  // landmark, plane: one per face
  const int end_of_landmarks = EndOfLandmarks(landmark_of_point);
  for (std::size_t f = 0; f < faces.faces.size(); ++f) {
    const auto& c = faces.faces[f].corners;
    if (std::min({c[0], c[1], c[2]}) >= end_of_landmarks) continue;
    const int plane = plane_index_of_face[f];
    const bool is_on_plane = plane >= 0 && !planes[plane].IsTentative();
    for (const int corner : c) {
      const int landmark = landmark_of_point[corner];
      if (landmark < 0) continue;
      ++faces_around[landmark];
      if (is_on_plane && !planes[plane].Has(map.landmarks[landmark]))
        on_planes.emplace_back(landmark, plane);
    }
  }
  std::sort(on_planes.begin(), on_planes.end());
  for (auto same = on_planes.begin(); same != on_planes.end();) {
    const auto end = std::find_if(same, on_planes.end(), [&](const auto& p) { return p != *same; });
    const auto [landmark, plane] = *same;
    const int count = static_cast<int>(end - same);
    same = end;
    if (count < 2 && 2 * count < faces_around[landmark]) continue;
    const TrackedPlane& known = planes[plane];
    const LandmarkEstimate& attached = map.landmarks[landmark];
    const double length_scale = LengthScale((attached.p_W - faces.camera.p_W).norm());
    out.attached.push_back({attached.id, known.id, 2 * known.detections.offset_m, length_scale});
  }
}

}  // namespace facet
