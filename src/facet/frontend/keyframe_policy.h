// SPDX-License-Identifier: BSD-2-Clause
// Decides which frames become keyframes, from stamps and track counts only.
#pragma once

#include <optional>

#include "facet/base/types.h"
#include "facet/frontend/frontend_options.h"

namespace facet {

enum class KeyframeReason { kNone, kFirst, kInterval, kFewTracks };

const char* ToString(KeyframeReason reason);

/// What a frame still sees of the last keyframe's points.
struct SharedPoints {
  int num_tracked = 0;
  int num_landmarks = 0;  ///< of these, as the same landmark
};

/// Not thread-safe.
class KeyframePolicy {
 public:
  explicit KeyframePolicy(const KeyframeOptions& options) : options_(options) {}

  /// Why the frame at t is a keyframe, or kNone. Call once per frame, in order; a keyframe becomes
  /// the last keyframe.
  KeyframeReason Decide(Timestamp t, const SharedPoints& shared);

  /// Has to be called after each keyframe with the number of points that it observes.
  void SetKeyframeSize(int num_points) { num_points_ = num_points; }

 private:
  KeyframeReason Reason(Timestamp t, const SharedPoints& shared) const;

  KeyframeOptions options_;
  std::optional<Timestamp> previous_frame_;
  Timestamp last_keyframe_;
  Duration frame_interval_;
  int num_points_ = 0;
};

}  // namespace facet
