// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/right_camera_watch.h"

namespace facet {
namespace {

// Too few corners say nothing about the rest of the image.
constexpr int kLeastTracks = 40;
constexpr double kSuspiciousShare = 0.5;  // of the usual one
constexpr double kAdaptation = 0.1;       // of the usual share, per keyframe
// What stands too near or moves in one keyframe may be gone in the next. Right images of another
// moment look like a turn that changes as the body's rotation does.
constexpr int kNumInRow = 3;
constexpr Duration kStretch{1'000'000'000}, kLongestBreak{2'000'000'000};
constexpr Duration kDistrust{5'000'000'000};
// A covered lens looks suspicious for as long as it is covered; every look costs milliseconds.
constexpr int kPassAfterVain = 12;

}  // namespace

bool RightCameraWatch::IsSuspicious(Timestamp t, int num_tracks, int num_near) {
  if (num_tracks < kLeastTracks) {
    if (!IsTrustedAt(t)) last_suspicious_ = t;  // nothing has dispelled the doubt
    return false;
  }
  const double share = static_cast<double>(num_near) / num_tracks;
  if (share >= kSuspiciousShare * usual_share_) {
    usual_share_ += kAdaptation * (share - usual_share_);
    num_in_row_ = num_to_pass_ = 0;
    matches_.clear();
    return false;
  }
  last_suspicious_ = t;
  if (num_to_pass_ == 0) return true;
  --num_to_pass_;
  return false;
}

std::optional<StereoTurn> RightCameraWatch::Add(Timestamp t,
                                                const StereoRig& rig,
                                                std::span<const StereoRays> matches) {
  if (num_in_row_ > 0 && t - last_in_row_ > kLongestBreak) {
    num_in_row_ = 0;
    matches_.clear();
  }
  matches_.insert(matches_.end(), matches.begin(), matches.end());
  if (num_in_row_ == 0) begin_ = t;
  last_in_row_ = t;
  if (++num_in_row_ < kNumInRow || t - begin_ < kStretch) return std::nullopt;
  const StereoTurn turn = EstimateStereoTurn(rig, matches_);
  num_in_row_ = 0;
  matches_.clear();
  if (turn.IsClear()) return turn;
  num_to_pass_ = kPassAfterVain;
  return std::nullopt;
}

bool RightCameraWatch::IsTrustedAt(Timestamp t) const {
  return !last_suspicious_ || t - *last_suspicious_ > kDistrust;
}

}  // namespace facet
