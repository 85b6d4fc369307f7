// SPDX-License-Identifier: BSD-2-Clause
// Error of tracked pixels against true poses: each landmark is fitted to its whole track (left and
// right pixels, robustly), what is left is the error of the front end.
#pragma once

#include <map>
#include <vector>

#include "facet/camera/stereo_rig.h"
#include "facet/map/observation.h"

namespace facet {

/// One stereo observation of a track with the true pose of the body.
struct TrackSample {
  std::size_t frame = 0;
  SE3 T_WB;
  FeatureObservation observation;
};

using TrackSamples = std::map<LandmarkId, std::vector<TrackSample>>;

/// Residual predicted - measured of one sample.
struct TrackResidual {
  std::size_t frame = 0;
  int age = 0;  ///< frames since the track began
  Vector2d left_px = Vector2d::Zero();
  std::optional<Vector2d> right_px;
  double sigma_left_px = 0, sigma_right_px = 0;  ///< as claimed by the front end
};

struct FittedTrack {
  LandmarkId id;
  double inverse_depth = 0;  ///< [1/m] in the first left camera
  std::vector<TrackResidual> residuals;
};

/// Fits each track of at least min_length samples.
std::vector<FittedTrack> FitTracks(const StereoRig& rig,
                                   const TrackSamples& tracks,
                                   int min_length);

/// Alternates fits of the landmarks and of the pose of each frame, to take the noise of a recorded
/// ground truth out of the residuals. The poses of `tracks` are replaced.
void RefinePoses(const StereoRig& rig, int rounds, TrackSamples& tracks);

/// Spread of one component of the residuals.
struct Spread {
  std::size_t count = 0;
  double mean = 0, robust_sigma = 0;  ///< 1.4826 times the median of |x - median|
  double rms = 0;                     ///< of the values below the limit
  double outliers = 0;                ///< share of values above the limit
};
Spread ComputeSpread(std::vector<double> values, double limit);

}  // namespace facet
