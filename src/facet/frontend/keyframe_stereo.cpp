// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/keyframe_stereo.h"

#include <algorithm>
#include <cmath>

namespace facet {

namespace {

// A right camera that is turned about its axis of view keeps some matches inside the gate: those of
// the middle of the image, and most of them near its edges.
constexpr double kNearShareOfGate = 0.5;
// To learn how far the right camera is turned: 0.6 deg with EuRoC's lens.
constexpr double kWideGate_px = 5;

}  // namespace

KeyframeStereo::KeyframeStereo(const StereoRig& rig, const FrontendOptions& options)
    : rig_(rig),
      options_(options),
      matcher_(rig, options),
      matches_(static_cast<std::size_t>(options.max_features)) {}

void KeyframeStereo::Clear() {
  std::fill(matches_.begin(), matches_.end(), std::nullopt);
  has_right_ = false;
}

std::optional<StereoTurn> KeyframeStereo::MatchTracks(const ImagePyramid& left,
                                                      const cv::Mat& right,
                                                      std::span<Track> tracks) {
  right_.Build(right, options_.klt.num_levels);
  has_right_ = true;
  MatchAll(left, tracks);
  if (!IsSuspicious(tracks)) return std::nullopt;
  const std::optional<StereoTurn> turn = watch_.Add(rig_, MatchWidely(left, tracks));
  if (!turn) return std::nullopt;
  rig_ = TurnedRig(rig_, turn->omega);
  matcher_.TurnRight(turn->omega);
  MatchAll(left, tracks);
  return turn;
}

void KeyframeStereo::MatchAll(const ImagePyramid& left, std::span<Track> tracks) {
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    Track& track = tracks[i];
    if (!track.id.IsValid()) continue;
    matches_[i] = matcher_.Match(track, left, right_);
    if (matches_[i]) track.inverse_depth = matches_[i]->inverse_depth;
  }
}

bool KeyframeStereo::IsSuspicious(std::span<const Track> tracks) {
  const double near_px = kNearShareOfGate * options_.stereo.max_epipolar_px;
  int num_tracks = 0, num_near = 0;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    num_tracks += tracks[i].id.IsValid() ? 1 : 0;
    num_near += matches_[i] && matches_[i]->off_line_px < near_px ? 1 : 0;
  }
  return watch_.IsSuspicious(num_tracks, num_near);
}

std::vector<StereoRays> KeyframeStereo::MatchWidely(const ImagePyramid& left,
                                                    std::span<const Track> tracks) {
  FrontendOptions options = options_;
  options.stereo.max_epipolar_px = kWideGate_px;
  StereoMatcher matcher(rig_, options);
  std::vector<StereoRays> rays;
  for (const Track& track : tracks) {
    if (!track.id.IsValid()) continue;
    const auto match = matcher.Match(track, left, right_);
    const auto ray = match ? rig_.cameras[1].Undistort(match->px) : std::nullopt;
    if (ray) rays.push_back({track.ray.xy, ray->xy});
  }
  return rays;
}

void KeyframeStereo::MatchPlaces(std::span<const DepthQuery> queries,
                                 const ImagePyramid& left,
                                 std::vector<SupportPoint>& found) {
  if (!has_right_) return;
  for (const DepthQuery& query : queries) {
    const auto ray = rig_.cameras[0].Undistort(query.px);
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
