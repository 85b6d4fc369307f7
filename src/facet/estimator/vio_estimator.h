// SPDX-License-Identifier: BSD-2-Clause
// The back end: observations and IMU samples in, states out. Fixed-lag smoothing over a window of
// keyframes (paper section II-B, pipeline S; docs/math.md, sections 3 to 6).
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "facet/base/stage_timer.h"
#include "facet/estimator/estimator_options.h"
#include "facet/estimator/solver/frame_update.h"
#include "facet/estimator/solver/marginalization.h"
#include "facet/estimator/solver/outlier_removal.h"
#include "facet/estimator/solver/window_solver.h"
#include "facet/estimator/window/window_snapshot.h"
#include "facet/imu/imu_buffer.h"
#include "facet/map/map_snapshot.h"
#include "facet/map/observation.h"
#include "facet/map/plane_assignments.h"
#include "facet/map/tracking_status.h"

namespace facet {

/// What AddFrame returns.
struct EstimatorResult {
  TrackingStatus status = TrackingStatus::kInitialising;
  std::string reason;      ///< why the status is not kOk, or empty
  bool has_state = false;  ///< false while initialising
  NavState state;          ///< causal estimate of this frame
  Matrix<15, 15> covariance =
      Matrix<15, 15>::Zero();  ///< theta p v b_g b_a; of the smoother, see docs
  int num_constraining = 0;    ///< landmarks that constrain the window and are seen in this frame
  bool was_reset = false;      ///< the estimator gave up its state and starts again with this frame
  SolveSummary solve;
  /// Keyframes with an IMU interval: how far it is from the solved window (see ImuErrorSigma).
  std::optional<double> imu_error_sigma;
  /// Keyframes that left the window, with their final poses.
  std::vector<KeyframePose> finished_keyframes;
};

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

  /// Comes into force with the next keyframe; calls before it add up. Of all that was said
  /// landmarks leave planes first, then they join.
  void Assign(const PlaneAssignments& assignments);

  bool is_initialised() const { return initialised_; }
  const SlidingWindow& window() const { return window_; }

  /// How many point-on-plane rows are in force.
  int NumPlaneConstraints() const;

  /// Latest state, keyframe poses, planes and landmarks.
  MapSnapshot Snapshot() const;

 private:
  EstimatorResult Start(const FrameObservations& observations, StageTimes& times);
  EstimatorResult TrackKeyframe(const FrameObservations& observations, StageTimes& times);
  EstimatorResult TrackPassingFrame(const FrameObservations& observations, StageTimes& times);

  bool HasEnoughFramesToStart() const;
  /// Frames at the beginning that say nothing of the others: dark ones, or without IMU after them.
  void DropUselessBeginning();
  void DropFirstFrame();

  void AppendFrame(const FrameObservations& observations, const ImuInterval& imu);
  void AppendFirstFrame(WindowFrame frame, const ImuInterval& imu);
  std::vector<PreparedObservation> Prepare(const FrameObservations& observations) const;
  void UpdateSqrtInfo(ImuLink& link) const;
  void RelinearizeImu();
  /// What Assign left comes into force.
  void TakeAssignments();
  /// After the solve: which planes are settled or too many, which relations do not hold.
  void JudgePlanes();
  void RemoveOutliers();
  bool DropWrongMembers();
  void Shrink(std::vector<KeyframePose>& finished);
  /// Of the planes that were ended, those that the prior does not know go at once ...
  void RemoveEndedPlanes();
  /// ... and the others are marginalised.
  void EndPlanes(MarginalizationPlan& plan);
  void KeepPlaneCovariances();
  void MoveOriginToNewestFrame();
  /// Whether the start is over; the window is solved anew when it ends.
  bool EndStart(std::vector<KeyframePose>& finished);
  /// Whether it ends now. If it does not but the window is full, drops a duplicate frame.
  bool UpdateStart(std::vector<KeyframePose>& finished);
  /// Final poses of the whole window, when it is given up.
  void FinishAllKeyframes(std::vector<KeyframePose>& finished) const;
  /// Where the newest frame is put in the world when the start succeeds.
  SE3 StartPose() const;
  double TiltSigma() const;
  void FillResult(const WindowFrame& frame, int num_used, EstimatorResult& result) const;
  int NumSeenInNewest() const;
  std::optional<double> NewestImuError() const;
  void Reset();

  StereoRig rig_;
  EstimatorOptions options_;
  PreintegrationNoise imu_noise_;
  BiasWalk bias_walk_;
  UsualError usual_error_;
  FactorNoise noise_;
  SlidingWindow window_;
  WindowSolver solver_;
  WindowValues before_solve_;
  FrameUpdater updater_;
  FrameGeometry geometry_;
  OutlierRemover outlier_remover_;
  /// The newest frame when it is not a keyframe: its IMU interval began at the newest keyframe.
  std::optional<WindowFrame> passing_;
  PlaneAssignments assignments_;  ///< to come into force with the next keyframe
  std::vector<PlaneId> ended_planes_;
  std::vector<PlaneCovariance> plane_covariances_;  ///< after the newest keyframe's solve
  bool initialised_ = false;
  bool start_is_over_ = false;
  Timestamp first_t_;
  std::optional<NavState> last_good_;  ///< newest keyframe that was not lost; survives a reset
  Matrix<15, 15> newest_covariance_ = Matrix<15, 15>::Zero();
};

}  // namespace facet
