// SPDX-License-Identifier: BSD-2-Clause
// Follows tracks from the previous left image to the newest one: frame to frame first, then aligned
// with the patch where the track began, so that errors do not add up from frame to frame.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "facet/camera/camera_model.h"
#include "facet/frontend/track.h"
#include "facet/frontend/tracking_summary.h"
#include "facet/geometry/se3.h"

namespace facet {

/// Not thread-safe.
class TemporalTracker {
 public:
  TemporalTracker(const CameraModel& camera, const FrontendOptions& options);

  /// From now on the camera is this one. Bearings of the track become those of the same pixels; one
  /// that has none gets an invalid id.
  void Calibrate(const CameraModel& camera, std::span<Track> tracks);

  /// Starts a track at px of the image, apart from its id. False: the place has no texture or ray.
  bool Begin(const ImagePyramid& now, const Vector2d& px, Track& track) const;

  /// Moves every track to the image `now`; tracks that are lost get an invalid id. T_now_prev is
  /// the predicted motion of the camera; a translation of zero means that it is not known.
  TrackingSummary Advance(const ImagePyramid& previous,
                          const ImagePyramid& now,
                          const SE3& T_now_prev,
                          std::span<Track> tracks);

 private:
  enum class Outcome { kTracked, kOutOfView, kNotFound, kNotReturned };
  struct Prediction {
    PatchWarp warp;
    bool is_close = false;  ///< near enough to begin at the start level
  };
  struct Images {
    const ImagePyramid& previous;
    const ImagePyramid& now;
  };

  std::unique_ptr<PatchPyramid> NewPatch() const;
  std::optional<Prediction> Predict(const SE3& T_now_prev, const Track& track) const;
  /// Seeks the lost tracks once more where they were, as if nothing had moved.
  void RetryInPlace(const Images& images, std::span<Track> tracks, TrackingSummary& summary);
  /// Tries finer to wider ranges of levels. The track is unchanged unless it was tracked.
  Outcome Follow(const Images& images, const Prediction& prediction, Track& track);
  Outcome FollowInRange(const Images& images,
                        const PatchWarp& prediction,
                        LevelRange range,
                        Track& track);
  /// Corrects `warp` (previous to now) by the reference patch. False: no longer similar.
  bool AlignWithReference(const ImagePyramid& now,
                          const Track& track,
                          PatchWarp& warp,
                          Alignment& found);
  bool ReturnsToStart(const ImagePyramid& previous,
                      const Track& track,
                      int level,
                      const PatchWarp& warp) const;
  /// The track's new state at `warp`, with scratch_ as its patch. False, and nothing changed: it
  /// needs a new reference, and there is no texture for one.
  bool Accept(const ImagePyramid& now,
              const PatchWarp& warp,
              const PixelBearing& ray,
              const Alignment& found,
              bool has_reference,
              Track& track);

  CameraModel camera_;
  FrontendOptions options_;
  PatchTracker frame_tracker_;
  PatchTracker reference_tracker_;
  std::unique_ptr<PatchPyramid> scratch_;
  std::unique_ptr<PatchPyramid> new_reference_;
  PatchWarp new_reference_warp_;
  std::vector<std::size_t> lost_;  // slots
};

}  // namespace facet
