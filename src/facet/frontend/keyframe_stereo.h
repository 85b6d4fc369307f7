// SPDX-License-Identifier: BSD-2-Clause
// The right image of a keyframe: where the tracks are in it, and the depths of further places.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <opencv2/core.hpp>

#include "facet/frontend/depth_query.h"
#include "facet/frontend/right_camera_watch.h"
#include "facet/frontend/stereo_matcher.h"

namespace facet {

/// Not thread-safe.
class KeyframeStereo {
 public:
  KeyframeStereo(const StereoRig& rig, const FrontendOptions& options);

  /// Forgets the right image: the newest frame has none, or none yet.
  void Clear();

  /// Seeks every live track in the right image; found ones take their depth from it. Returns how
  /// far the right camera has been turned since it was calibrated or corrected last, if this
  /// keyframe makes that clear; it is corrected from this keyframe on.
  std::optional<StereoTurn> MatchTracks(const ImagePyramid& left,
                                        const cv::Mat& right,
                                        std::span<Track> tracks);

  /// The match of the track in this slot; empty where there is none.
  const std::optional<StereoMatch>& match(std::size_t slot) const { return matches_[slot]; }
  bool has_right() const { return has_right_; }

  /// Matches further places of the left image, with the same tests as the tracks; appends what was
  /// found. Nothing without a right image.
  void MatchPlaces(std::span<const DepthQuery> queries,
                   const ImagePyramid& left,
                   std::vector<SupportPoint>& found);

 private:
  bool IsSuspicious(std::span<const Track> tracks);
  void MatchAll(const ImagePyramid& left, std::span<Track> tracks);
  std::vector<StereoRays> MatchWidely(const ImagePyramid& left, std::span<const Track> tracks);

  StereoRig rig_;  // with the turns that were found
  FrontendOptions options_;
  StereoMatcher matcher_;
  RightCameraWatch watch_;
  ImagePyramid right_;
  bool has_right_ = false;
  std::vector<std::optional<StereoMatch>> matches_;  // of the newest frame, by slot
  Track place_;                                      // of MatchPlaces
};

}  // namespace facet
