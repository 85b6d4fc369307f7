// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/solver/outlier_removal.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "facet/base/median.h"
#include "facet/estimator/factors/reprojection_factor.h"

namespace facet {

namespace {

// A landmark nearer than this is a mismatch.
constexpr double kMaxInverseDistance = 15.0;

// Norm of the error in sigmas; behind the camera: infinite.
double SigmasOff(const FrameGeometry& geometry,
                 const WindowLandmark& landmark,
                 const WindowObservation& o,
                 int camera,
                 const FactorNoise& noise) {
  const ReprojectionFactor factor(geometry, landmark, o, noise);
  const auto error = factor.Error(HostedPoint(landmark, geometry.current(landmark.host)), camera);
  return error ? factor.NoiseScale(camera) * error->norm()
               : std::numeric_limits<double>::infinity();
}

// Whether the landmark still has an observation. `removed` counts; the left errors are appended to
// `left_sigmas`.
bool RemoveFrom(WindowLandmark& landmark,
                const FrameGeometry& geometry,
                const FactorNoise& noise,
                double max_sigma,
                int& removed,
                std::vector<double>& left_sigmas) {
  for (WindowObservation& o : landmark.observations) {
    if (!o.has_right || SigmasOff(geometry, landmark, o, 1, noise) <= max_sigma) continue;
    o.has_right = false;
    ++removed;
  }
  removed += static_cast<int>(std::erase_if(landmark.observations, [&](const auto& o) {
    const double sigmas = SigmasOff(geometry, landmark, o, 0, noise);
    // Landmarks of pipeline SP have a loss of their own.
    if (!landmark.is_projection) left_sigmas.push_back(sigmas);
    return sigmas > max_sigma;
  }));
  return !landmark.observations.empty();
}

}  // namespace

OutlierRemoval OutlierRemover::Remove(const FrameGeometry& geometry,
                                      const FactorNoise& noise,
                                      double max_sigma,
                                      SlidingWindow& window) {
  OutlierRemoval out;
  left_sigmas_.clear();
  std::vector<char> gone(window.landmarks().size(), 0);
  for (std::size_t l = 0; l < window.landmarks().size(); ++l) {
    WindowLandmark& landmark = window.landmarks()[l];
    if (!IsConstraining(landmark)) continue;
    if (landmark.inverse_distance > kMaxInverseDistance ||
        !RemoveFrom(landmark, geometry, noise, max_sigma, out.num_removed, left_sigmas_)) {
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
  out.median_sigma = Median(left_sigmas_);
  return out;
}

}  // namespace facet
