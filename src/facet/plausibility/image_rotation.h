// SPDX-License-Identifier: BSD-2-Clause
// How the left camera turned, by following corners without any prediction. The front end's own
// tracks will not do: what contradicts the gyroscope is lost or removed there.
#pragma once

#include <optional>
#include <vector>

#include "facet/frontend/feature_detector.h"
#include "facet/frontend/frontend_options.h"
#include "facet/frontend/image_pyramid.h"
#include "facet/frontend/temporal_tracker.h"
#include "facet/plausibility/two_view_rotation.h"

namespace facet {

/// Not thread-safe.
class ImageRotation {
 public:
  explicit ImageRotation(const CameraModel& left);

  /// Of pyramids that are made for it alone.
  int num_levels() const { return options_.klt.num_levels; }

  /// Detects corners in the image that an interval begins with.
  void Begin(const ImagePyramid& left);
  /// The newest image begins an interval, with the corners that were followed to it; false if too
  /// few of them are left.
  bool BeginAgain();
  /// Follows them from the image of the last call to the next one. Returns which share is left.
  double Follow(const PyramidPair& left);
  /// From the first image of the interval to the newest one; empty if too few corners are left.
  std::optional<TwoViewRotation> Estimate() const;

 private:
  CameraModel camera_;
  FrontendOptions options_;
  TemporalTracker tracker_;
  int detection_level_;  // of the pyramid
  FeatureDetector detector_;
  std::vector<Track> tracks_;
  std::vector<Vector3d> first_;  // bearings where the tracks began
  int num_begun_ = 0;
  int num_followed_ = 0;  // to the newest image
};

}  // namespace facet
