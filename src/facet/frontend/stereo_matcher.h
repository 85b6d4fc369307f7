// SPDX-License-Identifier: BSD-2-Clause
// Finds the points of the left image in the right one.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "facet/camera/stereo_rig.h"
#include "facet/frontend/patch_tracker.h"
#include "facet/frontend/track.h"

namespace facet {

struct StereoMatch {
  Vector2d px = Vector2d::Zero();      ///< where the right camera, as it was calibrated, sees it
  double inverse_distance = 0;         ///< [1/m] from the left camera, at least 0
  double px_per_inverse_distance = 0;  ///< how far px moves when the inverse distance grows [px m]
  double off_line_px = 0;              ///< from the epipolar line
  float sigma_px = 0;                  ///< from the residuals of the alignment, per axis
  int level = 0;                       ///< finest level of the alignment
};

/// Not thread-safe.
class StereoMatcher {
 public:
  StereoMatcher(const StereoRig& rig, const FrontendOptions& options);

  /// From now on the rig is this one, with its right camera turned as before.
  void Calibrate(const StereoRig& rig);

  /// From now on the right camera is turned by omega [rad] further than before, in its own frame;
  /// the pixels of matches stay those of the rig that was calibrated.
  void TurnRight(const Vector3d& omega);

  /// Match of the track's place in the newest left image; empty when none can be trusted. Starts at
  /// the track's inverse distance where there is one, otherwise (or without success there) searches
  /// along the epipolar line.
  std::optional<StereoMatch> Match(const Track& track,
                                   const ImagePyramid& left,
                                   const ImagePyramid& right);

  /// Only around the given inverse distances [1/m], the first success counts. Of the track, px, ray
  /// and level are used.
  std::optional<StereoMatch> MatchNear(const Track& track,
                                       std::span<const double> inverse_distances,
                                       const ImagePyramid& left,
                                       const ImagePyramid& right);

 private:
  struct Candidate {
    double inverse_distance = 0;
    float zncc = -1;
  };

  /// The first value of an alignment, and the tracker that does it.
  struct Start {
    double inverse_distance = 0;
    int coarsest_level = 0;
    const PatchTracker& tracker;
  };

  std::optional<StereoMatch> Refine(const Track& track,
                                    const Start& start,
                                    const ImagePyramid& left,
                                    const ImagePyramid& right,
                                    float* zncc);
  /// Fills candidates_, best first.
  void Search(const Track& track, const ImagePyramid& left, const ImagePyramid& right);
  /// Inverse distance whose projection is nearest to the pixel, and the distance that is left.
  bool Triangulate(const PixelBearing& ray, const Vector2d& px_right, StereoMatch& match) const;
  /// Where the right camera would see it if it had not been turned.
  std::optional<Vector2d> AsCalibrated(const Vector2d& px_right) const;

  CameraModel right_camera_;
  SE3 T_C1C0_;
  std::optional<Quaterniond> turn_;  // of the right camera: from its axes to the calibrated ones
  StereoMatcherOptions options_;
  PatchTracker tracker_, near_tracker_;
  std::vector<Candidate> samples_;     // along the epipolar line
  std::vector<Candidate> candidates_;  // the best local maxima of samples_
  PatchPyramid patch_;                 // of the left image
  PatchPyramid back_;                  // of the right image
};

}  // namespace facet
