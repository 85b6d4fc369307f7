// SPDX-License-Identifier: BSD-2-Clause
// What the two halves of a stereo frame tell each other.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "facet/base/stage_timer.h"
#include "facet/frontend/stereo_frontend.h"
#include "facet/imu/imu_buffer.h"
#include "facet/map/map_snapshot.h"

namespace facet {

/// What the IMU and the last feedback say about a frame before its images are looked at.
struct MotionPrediction {
  ImuInterval imu;    ///< from the previous frame to this one
  FrontendHint hint;  ///< valid until the front stage predicts again
  /// The stamp is far ahead of all others: a damaged one, which would make what follows too late.
  bool is_stray = false;
  StageTimes times;
};

/// A frame whose features are tracked; the back half needs nothing else of it.
struct TrackedFrame {
  FrontendResult frontend;
  ImuInterval imu;             ///< from the previous frame to this one
  bool is_stray = false;       ///< see MotionPrediction; nothing was done
  bool used_feedback = false;  ///< the tracks were predicted with more than the gyroscope
  std::string refusal;         ///< see VioOutput
  std::string warning;         ///< the same
  StageTimes times;
};

/// State and landmarks after a keyframe; with them the front end predicts where tracked points will
/// be.
struct Feedback {
  FrameId frame;
  bool is_reset = false;  ///< the estimator started over: nothing is known any more
  NavState state;         ///< at the keyframe, IMU clock
  std::vector<LandmarkEstimate> landmarks;
  SE3 T_BC0;  ///< left camera to body, as it was given or, if it turned out to be wrong, as it is
  /// The calibration with which the landmarks were found, or, after a reset, with which they will
  /// be; null: none but the last one.
  std::shared_ptr<const StereoRig> rig;
};

}  // namespace facet
