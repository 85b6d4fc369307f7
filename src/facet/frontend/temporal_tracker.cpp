// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/temporal_tracker.h"

#include <algorithm>
#include <cmath>

#include "facet/frontend/warp_prediction.h"

namespace facet {
namespace {

// Finest and second finest level: what the reference patch is aligned on.
constexpr LevelRange kReferenceLevels = {1, 0};

// Free parameters of the warp from frame to frame (a shift; the prediction supplies the rest, and
// more parameters are noisier) and to the reference patch (shift, rotation and scale).
constexpr int kFrameParameters = 2, kReferenceParameters = 4;

// Coarsest pyramid level for points whose motion is predicted; others begin at the top.
constexpr int kStartLevel = 1;

// A reference patch is taken anew when the point has come nearer or gone farther by this factor, or
// when aligning with it would move the point by more than this.
constexpr float kMaxReferenceScale = 1.6F, kMaxReferenceShift_px = 1.5F;

// With more lost tracks than this per tracked one the prediction may be wrong: the lost ones are
// sought again as if nothing had moved.
constexpr double kRetryLostRatio = 0.5;

// Points this near to the border of the image are lost.
constexpr int kBorder_px = 4;

std::unique_ptr<PatchPyramid> NewReference() {
  return std::make_unique<PatchPyramid>(1 + kReferenceLevels.coarsest, kReferenceParameters);
}

}  // namespace

TemporalTracker::TemporalTracker(const CameraModel& camera, const FrontendOptions& options)
    : camera_(camera),
      options_(options),
      frame_tracker_(options.klt, kFrameParameters),
      reference_tracker_(options.klt, kReferenceParameters),
      scratch_(NewPatch()),
      new_reference_(NewReference()) {}

std::unique_ptr<PatchPyramid> TemporalTracker::NewPatch() const {
  return std::make_unique<PatchPyramid>(options_.klt.num_levels, kFrameParameters);
}

void TemporalTracker::Calibrate(const CameraModel& camera, std::span<Track> tracks) {
  const auto same_pixel = [&](const Vector3d& bearing) {
    const std::optional<Vector2d> px = camera_.Project(bearing);
    return px ? camera.Unproject(*px) : std::nullopt;
  };
  for (Track& track : tracks) {
    if (!track.id.IsValid()) continue;
    const std::optional<PixelBearing> ray = camera.BearingOf(track.px);
    if (!ray) {
      track.id = LandmarkId();
      continue;
    }
    track.ray = *ray;
    track.rotated_bearing = same_pixel(track.rotated_bearing).value_or(ray->bearing);
    if (track.keyframe_bearing) track.keyframe_bearing = same_pixel(*track.keyframe_bearing);
  }
  camera_ = camera;
}

bool TemporalTracker::Begin(const ImagePyramid& now, const Vector2d& px, Track& track) const {
  const std::optional<PixelBearing> ray = camera_.BearingOf(px);
  if (!ray) return false;
  const auto x = static_cast<float>(px.x()), y = static_cast<float>(px.y());
  if (!track.patch) {
    track.patch = NewPatch();
    track.reference = NewReference();
  }
  track.patch->Invalidate();
  track.reference->Invalidate();
  frame_tracker_.Extract(now, x, y, {kStartLevel, 0}, *track.patch);
  reference_tracker_.Extract(now, x, y, kReferenceLevels, *track.reference);
  if (!track.patch->IsValid(0) || !track.reference->IsValid(0)) return false;
  track.reference_warp = PatchWarp{};
  track.px = px;
  track.ray = *ray;
  track.sigma_px = 0;
  track.level = 0;
  track.is_renewed = false;
  track.inverse_distance.reset();
  track.drift.reset();
  track.keyframe_bearing.reset();
  return true;
}

std::optional<TemporalTracker::Prediction> TemporalTracker::Predict(const SE3& T_now_prev,
                                                                    const Track& track) const {
  // Translation known: the motion follows from the distance. Otherwise the point is assumed to go
  // on as it did, which is written as a translation of a point at unit distance.
  SE3 motion = T_now_prev;
  double inverse_distance = 0;
  Prediction prediction;
  if (!T_now_prev.p.isZero(0) && track.inverse_distance) {
    inverse_distance = *track.inverse_distance;
    prediction.is_close = true;
  } else if (track.drift) {
    motion.p = *track.drift;
    inverse_distance = 1;
    prediction.is_close = true;
  }
  const std::optional<PatchWarp> warp = PredictWarp(track.ray, inverse_distance, motion, camera_);
  if (!warp) return std::nullopt;
  prediction.warp = *warp;
  return prediction;
}

bool TemporalTracker::AlignWithReference(const ImagePyramid& now,
                                         const Track& track,
                                         PatchWarp& warp,
                                         Alignment& found) {
  PatchWarp aligned = ComposeLinear(warp, track.reference_warp);
  const float scale = Scale(aligned);
  if (!(scale < kMaxReferenceScale && scale * kMaxReferenceScale > 1)) return false;
  const auto min_zncc = static_cast<float>(options_.tracking.min_reference_zncc);
  const LevelRange range = {found.level, found.level};
  const Alignment result = reference_tracker_.Align(*track.reference, now, range, aligned);
  if (!result.ok || result.zncc < min_zncc) return false;
  const float shift = std::hypot(aligned.x - warp.x, aligned.y - warp.y);
  if (shift > kMaxReferenceShift_px) return false;
  warp.x = aligned.x;
  warp.y = aligned.y;
  new_reference_warp_ = aligned;
  found = result;
  return true;
}

bool TemporalTracker::ReturnsToStart(const ImagePyramid& previous,
                                     const Track& track,
                                     int level,
                                     const PatchWarp& warp) const {
  const auto x = static_cast<float>(track.px.x()), y = static_cast<float>(track.px.y());
  PatchWarp back = InverseAt(warp, x, y);
  if (!frame_tracker_.Align(*scratch_, previous, {level, level}, back).ok) return false;
  const float distance = std::hypot(back.x - x, back.y - y);
  const float scale = static_cast<float>(1 << level);
  return distance < scale * static_cast<float>(options_.tracking.max_forward_backward_px);
}

bool TemporalTracker::Accept(const ImagePyramid& now,
                             const PatchWarp& warp,
                             const PixelBearing& ray,
                             const Alignment& found,
                             bool has_reference,
                             Track& track) {
  if (has_reference) {
    track.reference_warp = new_reference_warp_;
  } else {
    new_reference_->Invalidate();
    reference_tracker_.Extract(now, warp.x, warp.y, kReferenceLevels, *new_reference_);
    if (!new_reference_->IsValid(found.level)) return false;
    std::swap(track.reference, new_reference_);
    track.reference_warp = PatchWarp{};
  }
  std::swap(track.patch, scratch_);
  track.px = Vector2d(warp.x, warp.y);
  track.ray = ray;
  track.drift = ray.bearing - track.rotated_bearing;
  track.sigma_px = found.sigma_px;
  track.level = found.level;
  track.is_renewed = !has_reference;
  return true;
}

TemporalTracker::Outcome TemporalTracker::FollowInRange(const Images& images,
                                                        const PatchWarp& prediction,
                                                        LevelRange range,
                                                        Track& track) {
  PatchWarp warp = prediction;
  Alignment found = frame_tracker_.Align(*track.patch, images.now, range, warp);
  if (!found.ok || found.zncc < static_cast<float>(options_.tracking.min_zncc)) {
    return Outcome::kNotFound;
  }
  const bool has_reference = AlignWithReference(images.now, track, warp, found);
  const Vector2d px(warp.x, warp.y);
  if (!camera_.IsInside(px, kBorder_px)) return Outcome::kOutOfView;
  scratch_->Invalidate();
  frame_tracker_.Extract(images.now, warp.x, warp.y, {kStartLevel, 0}, *scratch_);
  if (!ReturnsToStart(images.previous, track, found.level, warp)) return Outcome::kNotReturned;
  const std::optional<PixelBearing> ray = camera_.BearingOf(px);
  if (!ray) return Outcome::kOutOfView;
  const bool accepted = Accept(images.now, warp, *ray, found, has_reference, track);
  return accepted ? Outcome::kTracked : Outcome::kNotFound;
}

TemporalTracker::Outcome TemporalTracker::Follow(const Images& images,
                                                 const Prediction& prediction,
                                                 Track& track) {
  const int start = kStartLevel;
  const int top = images.now.num_levels() - 1;
  Outcome outcome = Outcome::kNotFound;
  if (prediction.is_close) {
    outcome = FollowInRange(images, prediction.warp, {start, 0}, track);
    if (outcome == Outcome::kTracked || outcome == Outcome::kOutOfView) return outcome;
  }
  const auto x = static_cast<float>(track.px.x()), y = static_cast<float>(track.px.y());
  frame_tracker_.Extract(images.previous, x, y, {top, start + 1}, *track.patch);
  outcome = FollowInRange(images, prediction.warp, {top, 0}, track);
  if (outcome != Outcome::kNotFound) return outcome;
  // Blurred images may agree on a coarser level only.
  return FollowInRange(images, prediction.warp, {top, 1}, track);
}

void TemporalTracker::RetryInPlace(const Images& images,
                                   std::span<Track> tracks,
                                   TrackingSummary& summary) {
  summary.retried = true;
  const auto found = std::remove_if(lost_.begin(), lost_.end(), [&](std::size_t slot) {
    Track& track = tracks[slot];
    Prediction in_place;
    in_place.warp.x = static_cast<float>(track.px.x());
    in_place.warp.y = static_cast<float>(track.px.y());
    return Follow(images, in_place, track) == Outcome::kTracked;
  });
  summary.num_not_found -= static_cast<int>(lost_.end() - found);
  summary.num_tracked += static_cast<int>(lost_.end() - found);
  lost_.erase(found, lost_.end());
}

TrackingSummary TemporalTracker::Advance(const ImagePyramid& previous,
                                         const ImagePyramid& now,
                                         const SE3& T_now_prev,
                                         std::span<Track> tracks) {
  const Images images = {previous, now};
  TrackingSummary summary;
  lost_.clear();
  for (std::size_t slot = 0; slot < tracks.size(); ++slot) {
    Track& track = tracks[slot];
    if (!track.id.IsValid()) continue;
    const Vector3d turned = T_now_prev.q * track.ray.bearing;
    const std::optional<Prediction> prediction = Predict(T_now_prev, track);
    track.rotated_bearing = turned;
    const Outcome outcome = prediction ? Follow(images, *prediction, track) : Outcome::kOutOfView;
    if (track.inverse_distance) {
      const double ratio = (turned + *track.inverse_distance * T_now_prev.p).norm();
      if (ratio > 0) track.inverse_distance = *track.inverse_distance / ratio;
    }
    summary.num_tracked += outcome == Outcome::kTracked ? 1 : 0;
    summary.num_out_of_view += outcome == Outcome::kOutOfView ? 1 : 0;
    summary.num_not_found += outcome == Outcome::kNotFound ? 1 : 0;
    summary.num_not_returned += outcome == Outcome::kNotReturned ? 1 : 0;
    if (outcome == Outcome::kNotFound)
      lost_.push_back(slot);
    else if (outcome != Outcome::kTracked)
      track.id = LandmarkId{};
  }
  const auto limit = kRetryLostRatio * summary.num_tracked;
  if (static_cast<double>(lost_.size()) > limit) RetryInPlace(images, tracks, summary);
  for (const std::size_t slot : lost_)
    tracks[slot].id = LandmarkId{};
  summary.num_refreshed =
      static_cast<int>(std::count_if(tracks.begin(), tracks.end(), [](const Track& track) {
        return track.id.IsValid() && track.is_renewed;
      }));
  return summary;
}

}  // namespace facet
