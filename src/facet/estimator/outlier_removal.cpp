// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/outlier_removal.h"

#include <algorithm>
#include <vector>

#include "facet/estimator/window_system.h"

namespace facet {

namespace {

// A landmark nearer than this is a mismatch.
constexpr double kMaxInverseDistance = 15.0;

// Whether the landmark still has an observation. `removed` counts.
bool RemoveFrom(WindowLandmark& landmark,
                const FrameGeometry& geometry,
                const RobustOptions& robust,
                double max_sigma,
                int& removed) {
  const auto is_outlier = [&](const WindowObservation& o, int camera) {
    const auto error = WhitenedError(geometry, landmark, o, camera);
    return !error || NoiseScale(landmark, o, camera, robust) * error->norm() > max_sigma;
  };
  for (WindowObservation& o : landmark.observations) {
    if (!o.has_right || !is_outlier(o, 1)) continue;
    o.has_right = false;
    ++removed;
  }
  removed += static_cast<int>(std::erase_if(
      landmark.observations, [&](const WindowObservation& o) { return is_outlier(o, 0); }));
  return !landmark.observations.empty();
}

}  // namespace

int RemoveOutlierObservations(const FrameGeometry& geometry,
                              const RobustOptions& robust,
                              double max_sigma,
                              SlidingWindow& window) {
  int removed = 0;
  std::vector<char> gone(window.landmarks().size(), 0);
  for (std::size_t l = 0; l < window.landmarks().size(); ++l) {
    WindowLandmark& landmark = window.landmarks()[l];
    if (!IsConstraining(landmark)) continue;
    if (landmark.inverse_distance > kMaxInverseDistance ||
        !RemoveFrom(landmark, geometry, robust, max_sigma, removed)) {
      gone[l] = 1;
      continue;
    }
    const bool has_host =
        std::any_of(landmark.observations.begin(),
                    landmark.observations.end(),
                    [&](const WindowObservation& o) { return o.frame == landmark.host; });
    if (!has_host) window.Rehost(landmark, landmark.observations.front().frame);
  }
  window.RemoveLandmarks(gone);
  return removed;
}

}  // namespace facet
