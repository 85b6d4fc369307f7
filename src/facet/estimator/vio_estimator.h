// SPDX-License-Identifier: BSD-2-Clause
// The back end: observations and IMU samples in, states out. Fixed-lag smoothing over a window of
// keyframes (paper section II-B; docs/math.md, sections 3 to 9).
#pragma once

#include <optional>
#include <vector>

#include "facet/base/stage_timer.h"
#include "facet/estimator/bias_watch.h"
#include "facet/estimator/contradiction.h"
#include "facet/estimator/estimator_options.h"
#include "facet/estimator/estimator_result.h"
#include "facet/estimator/innovation_judge.h"
#include "facet/estimator/planes/plane_lifecycle.h"
#include "facet/estimator/self_calibration.h"
#include "facet/estimator/solver/frame_update.h"
#include "facet/estimator/solver/window_optimizer.h"
#include "facet/estimator/start/segments.h"
#include "facet/estimator/start/vio_start.h"
#include "facet/estimator/stated_covariance.h"
#include "facet/estimator/window/imu_intervals.h"
#include "facet/imu/imu_buffer.h"
#include "facet/map/map_snapshot.h"
#include "facet/map/observation.h"
#include "facet/map/plane_assignments.h"

namespace facet {

/// Not thread-safe. Never throws for any content of the observations or samples.
class VioEstimator {
 public:
  VioEstimator(const StereoRig& rig, const ImuNoise& noise, const EstimatorOptions& options);

  /// `imu` covers the time from the previous frame to this one (ImuBuffer::Between); for the first
  /// frame it may hold samples from before, or be empty. Stages kImu, kOptimize, kMarginalize are
  /// timed.
  EstimatorResult AddFrame(const FrameObservations& observations,
                           const ImuInterval& imu,
                           StageTimes& times);

  /// Comes into force with the next keyframe; calls before it add up. First all landmarks
  /// are detached that were said to be, then the others are attached.
  void Assign(const PlaneAssignments& assignments) { planes_.Announce(assignments); }

  bool is_initialised() const { return start_.has_state(); }
  const SlidingWindow& window() const { return window_; }

  /// How many landmarks lie on planes, once per plane.
  int NumPlaneConstraints() const { return window_.NumPlaneLandmarks(); }

  /// What became of the calibration; empty if all of it is held, and before a second keyframe.
  std::optional<StereoRig> Calibration() const {
    return calibration_.Refined(stated_covariance_.OfLearnt());
  }
  bool HaveLensesRoom() const { return calibration_.HasRoom(CalibrationPart::kLenses); }
  const StereoRig* KeptRig() const { return calibration_.KeptRig(); }  ///< see SelfCalibration
  /// What is wrong with the given one by more than a careful calibration leaves.
  std::vector<CalibrationDeviation> GrossDeviations() const { return calibration_.Gross(); }
  /// When it was found so wrong last that a part of it was given room; poses of before have errors
  /// of another kind.
  const std::optional<Timestamp>& calibration_freed_at() const { return calibration_.freed_at(); }
  /// See SelfCalibration.
  void DoubtBaseline(double share) { calibration_.DoubtBaseline(share); }

  /// Latest state, keyframe poses, planes and landmarks.
  MapSnapshot Snapshot() const;

 private:
  bool IsAfterNewest(Timestamp t) const;
  void AppendFrame(const FrameObservations& observations, const ImuInterval& imu);
  ImageMotion ToImage(const PredictedFrame& frame) const;
  std::vector<PreparedObservation> Prepare(const FrameObservations& observations) const;

  /// Without what moves on its own. `link`: the IMU from the newest keyframe to the frame.
  std::vector<PreparedObservation> Believable(std::vector<PreparedObservation> observations,
                                              const ImuLink& link);

  EstimatorResult Start(const FrameObservations& observations, StageTimes& times);
  EstimatorResult TrackKeyframe(const FrameObservations& observations, StageTimes& times);
  EstimatorResult TrackIntermediateFrame(const FrameObservations& observations, StageTimes& times);

  SolveSummary Solve();
  void RemoveOutliers();
  /// Marginalises what does not fit into the window.
  void Shrink(std::vector<KeyframePose>& finished);
  void WatchBiases();
  void JudgeNoise();
  /// Gives up the state of the newest frame, a keyframe or not; the next frame is the first one of
  /// another segment.
  void StartOver(EstimatorResult& result);
  /// Everything but the segments.
  void Forget();
  EstimatorResult Estimate(const FrameObservations& observations, StageTimes& times);
  /// Of a state of this segment, with what is uncertain about all of it.
  Matrix<15, 15> InWorld(const Matrix<15, 15>& covariance, const NavState& x) const;
  /// The same with noise and calibration as they have turned out to be.
  Matrix<15, 15> Stated(const Matrix<15, 15>& covariance, const NavState& x) const;
  /// The state of the newest frame, before it is moved to where the image was taken.
  CausalState AtImu(const EstimatorResult& result) const;

  StereoRig rig_;
  LensFields held_fields_;  // beside their models, of lenses that are not estimated
  EstimatorOptions options_;
  SlidingWindow window_;
  /// The newest frame when it is not a keyframe; its link leads to the newest keyframe.
  std::optional<PredictedFrame> intermediate_;
  Matrix<15, 15> newest_covariance_ = Matrix<15, 15>::Zero();
  Segments segments_;  ///< survives StartOver
  ImuIntervals imu_;
  VioStart start_;
  SelfCalibration calibration_;
  InnovationJudge innovation_judge_;
  Contradiction contradiction_;
  BiasWatch bias_watch_;
  StatedCovariance stated_covariance_;
  std::optional<BiasDrift> bias_drift_;  // as of the newest keyframe
  WindowOptimizer optimizer_;
  WindowValues before_solve_;  ///< where to return to if wrong landmarks on planes bent the window
  PlaneLifecycle planes_;
  FrameUpdater updater_;
};

}  // namespace facet
