// SPDX-License-Identifier: BSD-2-Clause
// Tracks that contradict the motion of the others since the last keyframe.
#pragma once

#include <span>
#include <vector>

#include "facet/frontend/outlier_rejection.h"
#include "facet/frontend/track.h"

namespace facet {

/// Keeps its buffers; not thread-safe.
class TrackOutliers {
 public:
  /// Bearings are compared in pixels of this focal length.
  TrackOutliers(const OutlierOptions& options, double focal_px)
      : is_enabled_(options.enabled), rejection_(options, focal_px) {}

  /// Frees the slots of the tracks that contradict the others; returns how many. `R_keyframe_now`:
  /// rotation of the left camera since the last keyframe, from the gyroscope. If more than
  /// `max_share` of them do, none goes.
  int Remove(const Quaterniond& R_keyframe_now, double max_share, std::span<Track> tracks);

 private:
  bool is_enabled_;
  OutlierRejection rejection_;
  std::vector<BearingPair> pairs_;
  std::vector<std::size_t> slots_;  // of the pairs
  std::vector<unsigned char> is_outlier_;
};

}  // namespace facet
