// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/temporal_tracker.h"

#include <algorithm>
#include <cmath>

#include "facet/frontend/warp_prediction.h"

namespace facet {

TemporalTracker::TemporalTracker(const CameraModel& camera,
                                 const FrontendOptions& options,
                                 const PatchTracker& tracker)
    : camera_(camera), options_(options), tracker_(tracker) {}

bool TemporalTracker::AlignWithReference(const ImagePyramid& now,
                                         const Track& track,
                                         PatchWarp& warp,
                                         Alignment& found) {
  PatchWarp aligned = ComposeLinear(warp, track.reference_warp);
  const auto max_scale = static_cast<float>(options_.tracking.max_reference_scale);
  const float scale = Scale(aligned);
  if (!(scale < max_scale && scale * max_scale > 1)) return false;
  const Alignment result =
      tracker_.Align(*track.reference, now, {found.level, found.level}, aligned);
  if (!result.ok || result.zncc < static_cast<float>(options_.tracking.min_reference_zncc)) {
    return false;
  }
  const float shift = std::hypot(aligned.x - warp.x, aligned.y - warp.y);
  if (shift > static_cast<float>(options_.tracking.max_reference_shift_px)) return false;
  warp.x = aligned.x;
  warp.y = aligned.y;
  new_reference_warp_ = aligned;
  found = result;
  return true;
}

bool TemporalTracker::ReturnsToStart(const ImagePyramid& previous,
                                     const Track& track,
                                     const PatchWarp& warp) {
  const auto x = static_cast<float>(track.px.x()), y = static_cast<float>(track.px.y());
  PatchWarp back = InverseAt(warp, x, y);
  if (!tracker_.Align(*scratch_, previous, {1, 0}, back).ok) return false;
  const float distance = std::hypot(back.x - x, back.y - y);
  return distance < static_cast<float>(options_.tracking.max_forward_backward_px);
}

bool TemporalTracker::Follow(const ImagePyramid& previous,
                             const ImagePyramid& now,
                             const PatchWarp& prediction,
                             Track& track) {
  PatchWarp warp = prediction;
  const LevelRange all = {now.num_levels() - 1, 0};
  Alignment found = tracker_.Align(*track.patch, now, all, warp);
  if (!found.ok || found.zncc < static_cast<float>(options_.tracking.min_zncc)) return false;
  const bool has_reference = AlignWithReference(now, track, warp, found);
  const Vector2d px(warp.x, warp.y);
  if (!camera_.IsInside(px, options_.border_px)) return false;
  tracker_.Extract(now, warp.x, warp.y, all, *scratch_);
  if (!ReturnsToStart(previous, track, warp)) return false;
  const std::optional<UndistortedPoint> ray = camera_.Undistort(px);
  if (!ray) return false;

  std::swap(track.patch, scratch_);
  track.px = px;
  track.ray = *ray;
  track.sigma_px = found.sigma_px;
  track.level = found.level;
  if (has_reference) {
    track.reference_warp = new_reference_warp_;
  } else {
    *track.reference = *track.patch;
    track.reference_warp = PatchWarp{};
    ++num_refreshed_;
  }
  return true;
}

TrackingSummary TemporalTracker::Advance(const ImagePyramid& previous,
                                         const ImagePyramid& now,
                                         const SE3& T_now_prev,
                                         std::span<Track> tracks) {
  TrackingSummary summary;
  num_refreshed_ = 0;
  for (Track& track : tracks) {
    if (!track.id.IsValid()) continue;
    const std::optional<PatchWarp> prediction =
        PredictWarp(track.ray, track.inverse_depth.value_or(0), T_now_prev, camera_);
    if (prediction && Follow(previous, now, *prediction, track)) {
      ++summary.num_tracked;
    } else {
      track.id = LandmarkId{};
      ++summary.num_lost;
    }
  }
  summary.num_refreshed = num_refreshed_;
  return summary;
}

}  // namespace facet
