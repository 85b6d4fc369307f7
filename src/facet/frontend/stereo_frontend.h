// SPDX-License-Identifier: BSD-2-Clause
// From stereo images to observations of landmarks: gyro-predicted patch tracking from left image to
// left image, and on keyframes detection of new corners and left-right matching, of the tracks and
// of the support points between them.
#pragma once

#include <cstdint>
#include <memory>
#include <memory_resource>
#include <unordered_map>
#include <vector>

#include <opencv2/core.hpp>

#include "facet/base/stage_timer.h"
#include "facet/camera/stereo_rig.h"
#include "facet/frontend/depth_query.h"
#include "facet/frontend/frontend_options.h"
#include "facet/frontend/image_pyramid.h"
#include "facet/frontend/keyframe_policy.h"
#include "facet/frontend/right_image_findings.h"
#include "facet/frontend/tracking_summary.h"
#include "facet/map/observation.h"

namespace facet {

/// A stereo pair, 8 bit grey. An empty right image makes a mono frame.
///
/// The pixels are not copied but referenced until two further frames have been processed: do not
/// write into the same memory before that, or an image looks like a repetition of the one before.
struct StereoFrame {
  Timestamp t;
  cv::Mat left;
  cv::Mat right;
};

/// What earlier stages of the estimator know and the front end may use; all of it may be missing.
struct FrontendHint {
  /// Rotation of the body from this frame to the previous one, from the gyroscope: R_BprevBnow.
  Quaterniond R_prev_now = Quaterniond::Identity();
  /// Translation of the body now, in the previous body frame [m]; zero when not known.
  Vector3d p_prev_now = Vector3d::Zero();
  /// The estimator has a state, and the IMU between the frames has no holes: it will find what
  /// moves on its own better than the tracks among themselves.
  bool is_motion_known = false;
  /// Inverse distance [1/m] from the left camera at the previous frame, by landmark; may be null.
  const std::pmr::unordered_map<LandmarkId, double>* inverse_distance = nullptr;
  /// The calibration with which these distances were found; null: none but the last one.
  std::shared_ptr<const StereoRig> rig;
};

/// What the images of a keyframe tell the mesh.
struct KeyframeDepths {
  /// One per observation: [1/m] from the left camera; 0 where not known.
  std::vector<double> inverse_distances;
  std::vector<std::uint8_t> intensities;  ///< one per observation, of the left image
  std::vector<SupportPoint> support;      ///< points between the observations
};

/// Observations of one frame and what happened to the tracks.
struct FrontendResult {
  FrameObservations observations;
  KeyframeReason keyframe_reason = KeyframeReason::kNone;
  TrackingSummary tracking;  ///< points of the previous frame; num_tracked without the outliers
  KeyframeDepths depths;     ///< on keyframes; otherwise empty
  int num_outliers = 0;      ///< points removed because they contradict the motion of the others
  int num_new = 0;           ///< points that begin in this frame
  int num_stereo = 0;        ///< observations with a right pixel
  RightImageFindings right;  ///< on keyframes
  bool right_ok = false;     ///< keyframes: there was a right image that could be used
  bool image_ok = true;      ///< false: no left image, or one of the wrong size or type
  /// The left image is one of the last hundred although the camera has moved: it was not used.
  bool is_repeated = false;
  /// The left image has one grey value everywhere (lens covered, no light, exposure). Such a one is
  /// not called repeated, but is not used either where it is.
  bool is_blank = false;
  bool in_order = true;  ///< false: the stamp is not after the newest one; nothing was done
};

/// Owns the tracks. Deterministic: the same frames and hints give the same observations on every
/// machine and instruction set. Not thread-safe. Never throws for any content of the images; CHECKs
/// that the options are in range.
class StereoFrontend {
 public:
  StereoFrontend(const StereoRig& rig, const FrontendOptions& options);
  ~StereoFrontend();
  StereoFrontend(const StereoFrontend&) = delete;
  StereoFrontend& operator=(const StereoFrontend&) = delete;

  /// Processes the next frame. Frame ids count from 0 in the order of the calls; landmark ids are
  /// never used twice. A track whose reference patch no longer fits goes on as another landmark, so
  /// that what it has slid contradicts nothing. Adds the time to the stages kTrack, kStereo and
  /// kDetect.
  ///
  /// A left image that cannot be used, or is repeated, gives empty observations. The tracks are
  /// kept and sought in the next frame; the hints of both frames are composed. A frame that is not
  /// after the newest one gives empty observations and leaves the tracks and the hints as they are.
  FrontendResult Process(const StereoFrame& frame, const FrontendHint& hint, StageTimes& times);

  /// The left images that were used last; they reference their pixels.
  const PyramidPair& left_images() const;

  /// The calibration in use: the one that was given, until one that was hinted at moves points
  /// noticeably against it.
  const StereoRig& rig() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace facet
