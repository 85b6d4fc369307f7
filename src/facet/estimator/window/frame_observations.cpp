// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/window/frame_observations.h"

#include <optional>

namespace facet {

namespace {

// Beyond these a weight times its sigma is not a number any more, long before that it is no weight.
bool IsUsable(double sigma_px) {
  constexpr double kLeast_px = 1e-6, kLargest_px = 1e6;
  return sigma_px >= kLeast_px && sigma_px <= kLargest_px;
}

void SetCamera(int camera,
               const Vector2d& px,
               const PixelBearing& ray,
               double sigma_px,
               WindowObservation& observation) {
  observation.px[camera] = px;
  observation.sigma_px[camera] = sigma_px;
  observation.rays[camera] = {ray.bearing, ray.J_px_bearing / sigma_px};
}

}  // namespace

std::vector<PreparedObservation> PrepareObservations(const FrameObservations& observations,
                                                     const StereoRig& rig,
                                                     double pixel_sigma_scale,
                                                     const LensFields& beside_model) {
  std::vector<PreparedObservation> prepared;
  prepared.reserve(observations.features.size());
  for (const FeatureObservation& feature : observations.features) {
    const Vector2d px_left = ByModel(beside_model, 0, feature.px_left);
    const std::optional<PixelBearing> left = rig.cameras[0].BearingOf(px_left);
    if (!left || !IsUsable(feature.sigma_left_px)) continue;
    WindowObservation observation;
    SetCamera(0, px_left, *left, pixel_sigma_scale * feature.sigma_left_px, observation);
    if (feature.px_right && IsUsable(feature.sigma_right_px)) {
      const Vector2d px_right = ByModel(beside_model, 1, *feature.px_right);
      if (const auto right = rig.cameras[1].BearingOf(px_right)) {
        observation.has_right = true;
        SetCamera(1, px_right, *right, pixel_sigma_scale * feature.sigma_right_px, observation);
        observation.sigma_match_px = pixel_sigma_scale * feature.sigma_match_px;
      }
    }
    prepared.push_back({feature.landmark, observation});
  }
  return prepared;
}

void AppendObservations(const std::vector<PreparedObservation>& prepared, SlidingWindow& window) {
  const int newest = window.newest_frame();
  for (const PreparedObservation& p : prepared) {
    WindowLandmark* landmark = window.Find(p.landmark);
    if (landmark == nullptr) landmark = &window.AddLandmark(p.landmark, newest);
    if (!landmark->observations.empty() && landmark->observations.back().frame == newest) continue;
    landmark->observations.push_back(p.observation);
    landmark->observations.back().frame = newest;
  }
}

}  // namespace facet
