// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/keyframe_stereo.h"

#include <algorithm>
#include <cmath>

namespace facet {

KeyframeStereo::KeyframeStereo(const StereoRig& rig, const FrontendOptions& options)
    : left_camera_(rig.cameras[0]),
      options_(options),
      matcher_(rig, options),
      matches_(static_cast<std::size_t>(options.max_features)) {}

void KeyframeStereo::Clear() {
  std::fill(matches_.begin(), matches_.end(), std::nullopt);
  has_right_ = false;
}

void KeyframeStereo::MatchTracks(const ImagePyramid& left,
                                 const cv::Mat& right,
                                 std::span<Track> tracks) {
  right_.Build(right, options_.klt.num_levels);
  has_right_ = true;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    Track& track = tracks[i];
    if (!track.id.IsValid()) continue;
    matches_[i] = matcher_.Match(track, left, right_);
    if (matches_[i]) track.inverse_depth = matches_[i]->inverse_depth;
  }
}

void KeyframeStereo::MatchPlaces(std::span<const DepthQuery> queries,
                                 const ImagePyramid& left,
                                 std::vector<SupportPoint>& found) {
  if (!has_right_) return;
  for (const DepthQuery& query : queries) {
    const auto ray = left_camera_.Undistort(query.px);
    if (!ray) continue;
    place_.px = query.px;
    place_.ray = *ray;
    const std::span depths(query.inverse_depths.data(), static_cast<std::size_t>(query.num_depths));
    const auto match = matcher_.MatchNear(place_, depths, left, right_);
    if (!match || match->level != 0 || !(match->inverse_depth > 0)) continue;
    const double sigma_px =
        std::hypot(options_.noise.right_base_px, options_.noise.residual_factor * match->sigma_px);
    found.push_back({query.px,
                     match->px,
                     ray->xy,
                     match->inverse_depth,
                     sigma_px / match->px_per_inverse_depth});
  }
}

}  // namespace facet
