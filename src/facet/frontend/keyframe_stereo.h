// SPDX-License-Identifier: BSD-2-Clause
// The right image of a keyframe: where the tracks are in it, and the depths of further places.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <opencv2/core.hpp>

#include "facet/frontend/depth_query.h"
#include "facet/frontend/disparity_watch.h"
#include "facet/frontend/right_camera_watch.h"
#include "facet/frontend/right_image_findings.h"
#include "facet/frontend/stereo_matcher.h"

namespace facet {

/// Not thread-safe.
class KeyframeStereo {
 public:
  KeyframeStereo(const StereoRig& rig, const FrontendOptions& options);

  /// From this time on the rig is this one, with its right camera turned as before.
  void Calibrate(Timestamp t, const StereoRig& rig);

  /// The calibration with which the depths that tracks have were found; it may be nearly the one in
  /// use. What it explains is no contradiction.
  void SetRigOfDepths(std::shared_ptr<const StereoRig> rig) { rig_of_depths_ = std::move(rig); }

  const std::shared_ptr<const StereoRig>& rig_of_depths() const { return rig_of_depths_; }

  /// Forgets the right image: the newest frame has none, or none yet.
  void Clear();

  /// Seeks every live track in the right image; found ones take their depth from it.
  /// `are_depths_known`: those that tracks have are not from the last right image alone.
  RightImageFindings MatchTracks(Timestamp t,
                                 const ImagePyramid& left,
                                 const cv::Mat& right,
                                 bool are_depths_known,
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
  void MatchAll(const ImagePyramid& left, std::span<Track> tracks);
  /// Corrects the turn and matches again.
  void Turn(const Vector3d& omega, const ImagePyramid& left, std::span<Track> tracks);
  /// As if there were no right image.
  void Refuse(std::span<Track> tracks);
  void KeepDepths(std::span<const Track> tracks);
  void RestoreDepths(std::span<Track> tracks) const;

  bool IsSuspicious(Timestamp t, std::span<const Track> tracks);
  std::vector<StereoRays> MatchWidely(const ImagePyramid& left, std::span<const Track> tracks);
  DisparityShift ShiftOf(std::span<const Track> tracks);
  std::optional<double> InverseDistanceOf(const Track& track, const StereoMatch& match) const;

  StereoRig rig_;                               // with the turns that were found
  Quaterniond turn_ = Quaterniond::Identity();  // all of them
  std::shared_ptr<const StereoRig> rig_of_depths_;
  FrontendOptions options_;
  StereoMatcher matcher_;
  RightCameraWatch watch_;
  DisparityWatch disparities_;
  std::vector<std::optional<double>> depths_before_;  // inverse ones, by slot
  std::vector<double> angles_;                        // of ShiftOf
  ImagePyramid right_;
  bool has_right_ = false;
  std::vector<std::optional<StereoMatch>> matches_;  // of the newest frame, by slot
  Track place_;                                      // of MatchPlaces
};

}  // namespace facet
