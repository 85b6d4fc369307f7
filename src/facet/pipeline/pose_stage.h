// SPDX-License-Identifier: BSD-2-Clause
// Second part of a stereo frame: from tracked features and IMU samples to the pose.
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "facet/estimator/vio_estimator.h"
#include "facet/pipeline/calibration_watch.h"
#include "facet/pipeline/episodes.h"
#include "facet/pipeline/tracked_frame.h"
#include "facet/pipeline/vio_options.h"
#include "facet/pipeline/vio_output.h"
#include "facet/plausibility/motion_check.h"
#include "facet/plausibility/size_doubt.h"

namespace facet {

/// Not thread-safe. Never throws for any content of the frame.
class PoseStage {
 public:
  PoseStage(const StereoRig& rig, const ImuNoise& noise, const VioOptions& options);

  /// Everything in the output but the mesh.
  VioOutput Estimate(const TrackedFrame& frame);

  /// What was found in the mesh; comes into force with the next keyframe.
  void Assign(const PlaneAssignments& assignments) { estimator_.Assign(assignments); }

  /// After a keyframe or a reset: what the front stage may use from now on; otherwise empty. Once.
  std::optional<Feedback> TakeFeedback() { return std::exchange(feedback_, std::nullopt); }

  /// The keyframes that are still in the window, oldest first.
  std::vector<KeyframePose> WindowKeyframes() const;

  /// What has been learnt of it; see VioEstimator.
  std::optional<StereoRig> Calibration() const { return estimator_.Calibration(); }

 private:
  void FillPose(const TrackedFrame& frame, EstimatorResult result, VioOutput& out) const;
  std::string JudgeCalibration(const FrontendResult& frontend, const EstimatorResult& result);
  void CheckMotion(const TrackedFrame& frame, VioOutput& out);
  void HandBack(VioOutput& out);

  Duration time_offset_;
  SE3 T_BC0_;  // as it was given
  VioEstimator estimator_;
  CalibrationWatch calibration_;
  bool check_calibration_;
  Episodes contradictions_{Duration{10'000'000'000}};
  Episodes drifts_{Duration{10'000'000'000}};
  MotionCheck motion_check_;
  SizeDoubt size_doubt_;
  std::deque<std::string> waiting_warnings_;  // each is told once, with a frame that has no other
  std::optional<Timestamp> size_since_;  // its poses are all of after this change of calibration
  std::optional<Feedback> feedback_;
};

}  // namespace facet
