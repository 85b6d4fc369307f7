// SPDX-License-Identifier: BSD-2-Clause
// Second half of a stereo frame: estimation and output.
#pragma once

#include "facet/estimator/vio_estimator.h"
#include "facet/pipeline/calibration_watch.h"
#include "facet/pipeline/front_stage.h"
#include "facet/pipeline/mesh_stage.h"
#include "facet/pipeline/vio_output.h"
#include "facet/regularities/plane_tracker.h"
#include "facet/regularities/projection_landmarks.h"

namespace facet {

/// Not thread-safe.
class BackStage {
 public:
  BackStage(const StereoRig& rig, const ImuNoise& noise, const VioOptions& options);

  VioOutput Process(const FrontPacket& packet);

  /// After a keyframe or a reset: what the front stage may use from now on; empty otherwise.
  const std::optional<Feedback>& feedback() const { return feedback_; }

  std::vector<KeyframePose> WindowKeyframes() const { return estimator_.Snapshot().keyframes; }

  /// Of the whole run; its plane ids are those of Planes().
  std::optional<TriangleMesh> Map() const;
  /// Of what Map returns.
  MapMemory map_memory() const { return mesh_.map_memory(); }

  /// Every plane that was ever a variable, in the order of their ids.
  std::vector<PlaneRecord> Planes() const;

 private:
  void FindRegularities(VioOutput& out, MeshSnapshot& mesh);
  std::string JudgeCalibration(const FrontendResult& frontend, const EstimatorResult& result);
  void FillOutput(const FrontPacket& packet, EstimatorResult result, VioOutput& out);

  Duration time_offset_;
  VioEstimator estimator_;
  MeshStage mesh_;
  bool planes_judge_faces_;
  std::optional<PlaneTracker> planes_;              ///< pipeline SPR
  std::optional<ProjectionLandmarks> projections_;  ///< pipeline SP
  std::optional<Feedback> feedback_;
  CalibrationWatch calibration_;
};

}  // namespace facet
