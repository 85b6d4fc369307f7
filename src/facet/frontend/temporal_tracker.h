// SPDX-License-Identifier: BSD-2-Clause
// Follows tracks from the previous left image to the newest one: frame to frame first, then aligned
// with the patch where the track began, so that errors do not add up from frame to frame.
#pragma once

#include <span>

#include "facet/camera/camera_model.h"
#include "facet/frontend/track.h"
#include "facet/geometry/se3.h"

namespace facet {

struct TrackingSummary {
  int num_tracked = 0;
  int num_lost = 0;
  int num_refreshed = 0;
  bool retried = false;
};

/// Not thread-safe.
class TemporalTracker {
 public:
  /// The patch tracker must outlive this one.
  TemporalTracker(const CameraModel& camera,
                  const FrontendOptions& options,
                  const PatchTracker& tracker);

  /// Moves every track to the image `now`; tracks that are lost get an invalid id. T_now_prev is the
  /// predicted motion of the camera.
  TrackingSummary Advance(const ImagePyramid& previous,
                          const ImagePyramid& now,
                          const SE3& T_now_prev,
                          std::span<Track> tracks);

 private:
  /// Whether the track was found from this prediction; the track is unchanged otherwise.
  bool Follow(const ImagePyramid& previous,
              const ImagePyramid& now,
              const PatchWarp& prediction,
              Track& track);
  /// Corrects `warp` (previous to now) by the reference patch. False: no longer similar.
  bool AlignWithReference(const ImagePyramid& now, const Track& track, PatchWarp& warp, Alignment& found);
  bool ReturnsToStart(const ImagePyramid& previous, const Track& track, const PatchWarp& warp);

  CameraModel camera_;
  FrontendOptions options_;
  const PatchTracker& tracker_;
  std::unique_ptr<PatchPyramid> scratch_ = std::make_unique<PatchPyramid>();
  PatchWarp new_reference_warp_;
  int num_refreshed_ = 0;
};

}  // namespace facet
