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
double SigmasOff(const WindowLandmark& landmark,
                 const WindowObservation& observation,
                 int camera,
                 const FrameGeometry& geometry,
                 const FactorNoise& noise) {
  const ReprojectionFactor factor(geometry, landmark, observation, noise);
  const auto error = factor.Error(HostedPoint(landmark, geometry.current(landmark.host)), camera);
  return error ? factor.NoiseScale(camera) * error->norm()
               : std::numeric_limits<double>::infinity();
}

bool IsSeenByHost(const WindowLandmark& landmark) {
  return std::any_of(landmark.observations.begin(),
                     landmark.observations.end(),
                     [&](const WindowObservation& o) { return o.frame == landmark.host; });
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
    if (landmark.inverse_distance > kMaxInverseDistance) {
      gone[l] = 1;
      continue;
    }
    out.num_removed += RemoveFrom(geometry, noise, max_sigma, landmark);
    if (landmark.observations.empty()) {
      gone[l] = 1;
    } else if (!IsSeenByHost(landmark)) {
      window.Rehost(landmark, landmark.observations.front().frame);
    }
  }
  window.RemoveLandmarks(gone);
  out.median_sigma = Median(left_sigmas_);
  return out;
}

// Returns how many observations went, of the right camera alone or of both.
int OutlierRemover::RemoveFrom(const FrameGeometry& geometry,
                               const FactorNoise& noise,
                               double max_sigma,
                               WindowLandmark& landmark) {
  int num_removed = 0;
  for (WindowObservation& o : landmark.observations) {
    if (!o.has_right || SigmasOff(landmark, o, 1, geometry, noise) <= max_sigma) continue;
    o.has_right = false;
    ++num_removed;
  }
  num_removed += static_cast<int>(std::erase_if(landmark.observations, [&](const auto& o) {
    const double sigmas = SigmasOff(landmark, o, 0, geometry, noise);
    // Landmarks of pipeline SP have a loss of their own.
    if (!landmark.is_projection) left_sigmas_.push_back(sigmas);
    return sigmas > max_sigma;
  }));
  return num_removed;
}

}  // namespace facet
