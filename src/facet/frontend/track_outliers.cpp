// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/track_outliers.h"

#include <algorithm>

namespace facet {

int TrackOutliers::Remove(const Quaterniond& R_keyframe_now,
                          double max_share,
                          std::span<Track> tracks) {
  if (!is_enabled_) return 0;
  pairs_.clear();
  slots_.clear();
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    const Track& track = tracks[i];
    if (!track.id.IsValid() || !track.keyframe_bearing) continue;
    pairs_.push_back({*track.keyframe_bearing, R_keyframe_now * track.Bearing()});
    slots_.push_back(i);
  }
  if (rejection_.Find(pairs_, is_outlier_) != OutlierVerdict::kTrusted) return 0;
  const auto num_outliers = std::count_if(is_outlier_.begin(),
                                          is_outlier_.end(),
                                          [](unsigned char is_outlier) { return is_outlier != 0; });
  if (static_cast<double>(num_outliers) > max_share * static_cast<double>(pairs_.size())) return 0;
  int num_removed = 0;
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    if (is_outlier_[k] == 0) continue;
    tracks[slots_[k]].id = LandmarkId{};
    ++num_removed;
  }
  return num_removed;
}

}  // namespace facet
