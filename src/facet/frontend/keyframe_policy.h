// SPDX-License-Identifier: BSD-2-Clause
// Decides which frames become keyframes, from stamps and track counts only.
#pragma once

#include <optional>

#include "facet/base/types.h"
#include "facet/frontend/frontend_options.h"

namespace facet {

enum class KeyframeReason { kNone, kFirst, kStart, kInterval, kFewTracks };

const char* ToString(KeyframeReason reason);

/// Not thread-safe.
class KeyframePolicy {
 public:
  explicit KeyframePolicy(const KeyframeOptions& options) : options_(options) {}

  /// Why the frame at t is a keyframe, or kNone. `num_shared` points of the last keyframe are still
  /// tracked. Call once per frame, in order; a keyframe becomes the last keyframe.
  KeyframeReason Decide(Timestamp t, int num_shared);

  /// To be told after each keyframe: the number of points that it observes.
  void SetKeyframeSize(int num_points) { num_points_ = num_points; }

 private:
  KeyframeReason Reason(Timestamp t, int num_shared) const;

  KeyframeOptions options_;
  std::optional<Timestamp> first_;
  std::optional<Timestamp> previous_frame_;
  Timestamp last_keyframe_;
  Duration frame_interval_;
  int num_points_ = 0;
};

}  // namespace facet
