// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/keyframe_policy.h"

namespace facet {

const char* ToString(KeyframeReason reason) {
  switch (reason) {
    case KeyframeReason::kNone:
      return "none";
    case KeyframeReason::kFirst:
      return "first";
    case KeyframeReason::kInterval:
      return "interval";
    case KeyframeReason::kFewTracks:
      return "few_tracks";
  }
  return "";
}

KeyframeReason KeyframePolicy::Reason(Timestamp t, const SharedPoints& shared) const {
  if (!previous_frame_) return KeyframeReason::kFirst;
  if (t < last_keyframe_) return KeyframeReason::kInterval;  // the clock was set back
  const Duration since_keyframe = t - last_keyframe_;
  // Stamps jitter; half a frame more or less must not turn every 4th frame into every 5th.
  const Duration tolerance = {frame_interval_.ns / 2};
  if (since_keyframe + tolerance >= FromSeconds(options_.interval_s)) {
    return KeyframeReason::kInterval;
  }
  if (num_points_ == 0 || shared.num_tracked < options_.min_tracked_ratio * num_points_ ||
      shared.num_landmarks < options_.min_landmark_ratio * num_points_) {
    return KeyframeReason::kFewTracks;
  }
  return KeyframeReason::kNone;
}

KeyframeReason KeyframePolicy::Decide(Timestamp t, const SharedPoints& shared) {
  if (previous_frame_) {
    // The shortest interval seen, so that a dropped frame does not widen the tolerance.
    const Duration dt = t - *previous_frame_;
    const bool first_interval = frame_interval_.ns == 0;
    if (dt.ns > 0 && (first_interval || dt < frame_interval_)) frame_interval_ = dt;
  }
  const KeyframeReason reason = Reason(t, shared);
  previous_frame_ = t;
  if (reason != KeyframeReason::kNone) last_keyframe_ = t;
  return reason;
}

}  // namespace facet
