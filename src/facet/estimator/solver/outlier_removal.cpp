// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/solver/outlier_removal.h"

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "facet/base/median.h"
#include "facet/estimator/factors/reprojection_factor.h"

namespace facet {

namespace {

// A landmark nearer than this is a mismatch.
constexpr double kMaxInverseDistance = 15.0;

// Norms of the errors in sigmas; behind the camera: infinite.
std::array<double, 2> SigmasOff(const WindowLandmark& landmark,
                                const WindowObservation& observation,
                                const HostedPoint& point,
                                const FrameGeometry& geometry,
                                const FactorNoise& noise) {
  const ReprojectionFactor factor(geometry, landmark, observation, noise);
  const ReprojectionFactor::Errors errors = factor.ErrorsOf(point);
  std::array<double, 2> sigmas;
  for (std::size_t c = 0; c < 2; ++c) {
    sigmas[c] = errors[c] ? factor.NoiseScale(static_cast<int>(c)) * errors[c]->norm()
                          : std::numeric_limits<double>::infinity();
  }
  return sigmas;
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
  const HostedPoint point(landmark, geometry.current(landmark.host));
  auto kept = landmark.observations.begin();
  for (WindowObservation& o : landmark.observations) {
    const auto [left, right] = SigmasOff(landmark, o, point, geometry, noise);
    // Landmarks of pipeline SP have a loss of their own.
    if (!landmark.is_projection) left_sigmas_.push_back(left);
    if (o.has_right && right > max_sigma) {
      o.has_right = false;
      ++num_removed;
    }
    if (left > max_sigma) {
      ++num_removed;
    } else {
      *kept++ = o;
    }
  }
  landmark.observations.erase(kept, landmark.observations.end());
  return num_removed;
}

}  // namespace facet
