// SPDX-License-Identifier: BSD-2-Clause
// What the front end hands to the estimator for one stereo frame.
#pragma once

#include <optional>
#include <vector>

#include "facet/base/types.h"

namespace facet {

/// One landmark seen in one stereo frame, in raw (distorted) pixels.
struct FeatureObservation {
  LandmarkId landmark;
  Vector2d px_left = Vector2d::Zero();
  std::optional<Vector2d> px_right;
  double sigma_left_px = 0.5;  ///< 1-sigma per axis
  double sigma_right_px = 0.5;
  /// 1-sigma per axis of the match alone: what the right pixel is off besides what the left one is.
  /// A place that slides in the left image takes its match along. 0: left and right pixel are off
  /// each for itself.
  double sigma_match_px = 0;
};

/// All observations of one stereo frame; each landmark at most once.
struct FrameObservations {
  FrameId frame;
  Timestamp t;  ///< stamp of the left image, camera clock
  bool is_keyframe = false;
  std::vector<FeatureObservation> features;
};

}  // namespace facet
