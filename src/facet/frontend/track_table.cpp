// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/track_table.h"

#include <algorithm>

#include "facet/base/check.h"

namespace facet {

TrackTable::TrackTable(int num_slots) {
  FACET_CHECK(num_slots > 0) << num_slots;
  slots_.resize(static_cast<std::size_t>(num_slots));
}

void TrackTable::RenameRenewed() {
  for (Track& track : slots_) {
    if (track.id.IsValid() && track.is_renewed) track.id = NewLandmark();
  }
}

std::span<const Vector2d> TrackTable::Places() {
  places_.clear();
  for (const Track& track : slots_) {
    if (track.id.IsValid()) places_.push_back(track.px);
  }
  return places_;
}

std::span<const std::size_t> TrackTable::ByLandmark() {
  order_.clear();
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    if (slots_[i].id.IsValid()) order_.push_back(i);
  }
  std::sort(order_.begin(), order_.end(), [this](std::size_t i, std::size_t j) {
    return slots_[i].id < slots_[j].id;
  });
  return order_;
}

int TrackTable::StartKeyframe() {
  int size = 0;
  for (Track& track : slots_) {
    track.keyframe_bearing.reset();
    if (!track.id.IsValid()) continue;
    track.keyframe_bearing = track.Bearing();
    ++size;
  }
  first_after_keyframe_ = LandmarkId{next_landmark_};
  return size;
}

SharedPoints TrackTable::CountShared() const {
  SharedPoints shared;
  for (const Track& track : slots_) {
    if (!track.id.IsValid() || !track.keyframe_bearing) continue;
    ++shared.num_tracked;
    shared.num_landmarks += track.id < first_after_keyframe_ ? 1 : 0;
  }
  return shared;
}

}  // namespace facet
