// SPDX-License-Identifier: BSD-2-Clause
// How far the right camera is turned against its calibration, from the matches of a few stereo
// pairs alone.
#pragma once

#include <span>
#include <string>

#include "facet/camera/stereo_rig.h"

namespace facet {

/// The same point in both images: unit vectors of each camera.
struct StereoRays {
  Vector3d left, right;
};

struct StereoTurn {
  /// The right camera's axes are turned by this against the calibration, in its own frame [rad].
  /// About its y axis the images hardly tell; that part stays next to nothing.
  Vector3d omega = Vector3d::Zero();
  /// Medians of the distances from the epipolar lines, as angles, in pixels of the mean focal
  /// length.
  double before_px = 0, after_px = 0;
  int num_matches = 0;
  /// If it was found along the epipolar lines, by known depths: the shift there [px]; otherwise 0.
  double along_px = 0;

  /// It explains distances that no careful calibration leaves.
  bool IsClear() const;
};

/// Robust least squares over the matches, with a prior of 0.5 deg about x and z.
StereoTurn EstimateStereoTurn(const StereoRig& rig, std::span<const StereoRays> matches);

/// The rig with its right camera turned by omega.
StereoRig TurnedRig(const StereoRig& rig, const Vector3d& omega);

/// How far, and what the correction brings.
std::string InWords(const StereoTurn& turn);

}  // namespace facet
