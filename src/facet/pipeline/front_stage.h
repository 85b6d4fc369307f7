// SPDX-License-Identifier: BSD-2-Clause
// First half of a stereo frame: IMU interval, prediction, feature tracking.
#pragma once

#include <deque>
#include <memory_resource>
#include <optional>
#include <string>
#include <unordered_map>

#include "facet/imu/imu_buffer.h"
#include "facet/pipeline/episodes.h"
#include "facet/pipeline/tracked_frame.h"
#include "facet/pipeline/vio_options.h"
#include "facet/plausibility/calibration_check.h"
#include "facet/plausibility/dead_axis_check.h"
#include "facet/plausibility/dead_imu_check.h"

namespace facet {

/// Not thread-safe. Deterministic: frame k uses the newest feedback of a keyframe k - kLag or
/// older, no matter how far the back half has come.
class FrontStage {
 public:
  /// The back half may work on one frame while this one works on the next.
  static constexpr std::int64_t kLag = 2;

  /// IMU samples older than this are forgotten until the first frame comes.
  static constexpr Duration kLongestHistory{600'000'000'000};

  FrontStage(const StereoRig& rig, const VioOptions& options);

  /// In order of time (IMU clock); refuses and counts what is not finite or not in order.
  void AddImu(const ImuSample& sample);
  int num_refused_imu() const { return num_refused_imu_; }
  int num_stray_imu() const { return imu_.num_stray(); }
  const ImuScreenCounts& imu_screen_counts() const { return imu_.screen_counts(); }
  void AddFeedback(Feedback feedback) { feedback_.push_back(std::move(feedback)); }

  /// How the body moved to the frame at t (camera clock), and where landmarks will be seen in it.
  MotionPrediction Predict(Timestamp t);

  /// Tracks the features from the previous left image; on keyframes detects new ones and matches
  /// left to right. After Predict for the same frame.
  TrackedFrame Track(const StereoFrame& frame, MotionPrediction prediction);

  /// How far the right camera is turned against its calibration, in its own frame; empty: it is not
  /// known to be.
  const std::optional<Quaterniond>& right_turn() const { return right_turn_; }

  std::size_t num_imu_samples() const { return imu_.size(); }

 private:
  bool IsStray(Timestamp t_imu);
  ImuInterval IntervalTo(Timestamp t_imu) const;
  FrontendHint MakeHint(const ImuInterval& now);
  bool IsOldEnough(const Feedback& feedback) const {
    return feedback.frame.value <= next_frame_ - kLag;
  }
  void TakeFeedback();
  std::string WatchAxes(const ImuInterval& imu);
  std::string JudgeRightImage(Timestamp t, const RightImageFindings& found);
  std::string FollowTurn(const StereoTurn& turn);
  std::string CheckSensors(const TrackedFrame& tracked);
  void ForgetOldImu();

  Duration time_offset_;
  double max_gap_s_, gravity_;
  StereoFrontend frontend_;
  bool check_calibration_;
  std::optional<Quaterniond> right_turn_;
  Episodes right_contradicts_{Duration{10'000'000'000}};
  DeadImuCheck dead_imu_;
  DeadAxisCheck dead_axes_;
  CalibrationCheck calibration_;
  ImuBuffer imu_;
  int num_refused_imu_ = 0;
  std::deque<Feedback> feedback_;  ///< front: in use (if its frame is old enough)
  bool has_feedback_ = false;
  std::int64_t next_frame_ = 0;
  bool has_previous_ = false;
  Timestamp previous_t_;          ///< IMU clock
  int num_strays_ = 0;            ///< in a row, near each other
  Timestamp newest_stray_;        ///< IMU clock
  std::deque<Timestamp> recent_;  ///< of the last kLag frames, IMU clock
  std::pmr::unsynchronized_pool_resource inverse_distance_memory_;  ///< kept from frame to frame
  std::pmr::unordered_map<LandmarkId, double> inverse_distance_{&inverse_distance_memory_};
};

}  // namespace facet
