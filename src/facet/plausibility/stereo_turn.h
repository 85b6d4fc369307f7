// SPDX-License-Identifier: BSD-2-Clause
// How far the right camera is turned against its calibration, from a few stereo pairs alone. A bump
// of 0.2 deg moves its image by more than the gate of the front end, which then has no match to
// learn that from.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <opencv2/core.hpp>

#include "facet/camera/stereo_rig.h"

namespace facet {

/// The same point in both images, on the plane z = 1 of each camera.
struct StereoRays {
  Vector2d left, right;
};

struct StereoTurn {
  /// The right camera's axes are turned by this against the calibration, in its own frame [rad].
  /// About its y axis the images hardly tell; that part stays small.
  Vector3d omega = Vector3d::Zero();
  /// Medians of the distances from the epipolar lines, in pixels of the mean focal length.
  double before_px = 0, after_px = 0;
  int num_matches = 0;

  /// It explains distances that no careful calibration leaves.
  bool IsClear() const;
};

/// Matches corners of the left image with the right one, as far from the epipolar lines as
/// `gate_px`.
std::vector<StereoRays> MatchWidely(const StereoRig& rig,
                                    const cv::Mat& left,
                                    const cv::Mat& right,
                                    double gate_px = 5);

/// A pair with fewer matches may have its images exchanged; a hundred and more are usual.
inline constexpr std::size_t kFewStereoMatches = 20;

/// Whether left and right are exchanged, from the matches of some pairs as they are and, of those
/// pairs that have few, of their images exchanged.
bool AreSwapped(std::size_t num_matches, std::size_t num_exchanged);

/// Robust least squares over the matches, with a prior of 0.5 deg.
StereoTurn EstimateStereoTurn(const StereoRig& rig, std::span<const StereoRays> matches);

/// The rig with its right camera turned by omega.
StereoRig TurnedRig(const StereoRig& rig, const Vector3d& omega);

}  // namespace facet
