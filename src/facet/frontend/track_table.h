// SPDX-License-Identifier: BSD-2-Clause
// The tracks of the front end and the names of the landmarks that they follow.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "facet/frontend/keyframe_policy.h"
#include "facet/frontend/track.h"

namespace facet {

/// A fixed number of slots; one whose track has no valid id is free. Not thread-safe.
class TrackTable {
 public:
  explicit TrackTable(int num_slots);

  std::span<Track> slots() { return slots_; }
  const Track& operator[](std::size_t slot) const { return slots_[slot]; }

  /// A landmark id that was never given out before.
  LandmarkId NewLandmark() { return LandmarkId{next_landmark_++}; }

  /// A track whose reference patch was taken anew goes on as another landmark: what it slid until
  /// then stays in it for good, and contradicts nothing under another name.
  void RenameRenewed();

  /// Where the live tracks are in the newest image; valid until the next call.
  std::span<const Vector2d> Places();

  /// The slots of the live tracks in the order of their landmarks; valid until the next call.
  std::span<const std::size_t> ByLandmark();

  /// Remembers where each track is in this keyframe. Returns how many there are.
  int StartKeyframe();

  /// What the newest frame still sees of the last keyframe's points.
  SharedPoints CountShared() const;

 private:
  std::vector<Track> slots_;
  std::int64_t next_landmark_ = 0;
  LandmarkId first_after_keyframe_;  // landmarks from this one on are newer than the last keyframe
  std::vector<Vector2d> places_;
  std::vector<std::size_t> order_;
};

}  // namespace facet
