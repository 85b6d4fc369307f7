// SPDX-License-Identifier: BSD-2-Clause
// How the left camera turned, by following corners without any prediction. The front end's own
// tracks will not do: what contradicts the gyroscope is lost or removed there.
#pragma once

#include <optional>
#include <vector>

#include <opencv2/core.hpp>

#include "facet/frontend/feature_detector.h"
#include "facet/frontend/frontend_options.h"
#include "facet/frontend/image_pyramid.h"
#include "facet/frontend/temporal_tracker.h"
#include "facet/plausibility/two_view_rotation.h"

namespace facet {

/// Not thread-safe. References the pixels of the newest image until the next call.
class ImageRotation {
 public:
  explicit ImageRotation(const CameraModel& left);

  /// Detects corners in the image that an interval begins with.
  void Begin(const cv::Mat& left);
  /// The newest image begins an interval, with the corners that were followed to it; false if too
  /// few of them are left.
  bool BeginAgain();
  /// Follows them to the next image. Returns which share is left.
  double Follow(const cv::Mat& left);
  /// From the first image of the interval to the newest one; empty if too few corners are left.
  std::optional<TwoViewRotation> Estimate() const;

 private:
  CameraModel camera_;
  FrontendOptions options_;
  TemporalTracker tracker_;
  int detection_level_;  // of the pyramid
  FeatureDetector detector_;
  ImagePyramid previous_, now_;
  std::vector<Track> tracks_;
  std::vector<Vector3d> first_;  // bearings where the tracks began
  int num_begun_ = 0;
  int num_followed_ = 0;  // to the newest image
};

}  // namespace facet
