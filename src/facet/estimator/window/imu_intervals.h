// SPDX-License-Identifier: BSD-2-Clause
// The IMU side of frames: makes the interval that leads to a new frame, and the frame's predicted
// state with it.
#pragma once

#include <optional>

#include "facet/estimator/window/sliding_window.h"
#include "facet/imu/imu_buffer.h"

namespace facet {

/// Where the IMU says that a new frame is, and the link that says so.
struct PredictedFrame {
  NavState x;
  ImuLink link;
};

/// Intervals follow each other without a hole, in the clock of the IMU. Not thread-safe.
class ImuIntervals {
 public:
  /// `time_offset`: t_imu - t_camera.
  ImuIntervals(const ImuNoise& noise, const ImuOptions& options, Duration time_offset);

  /// The first frame of a run, by the camera's clock: it has no interval.
  void Begin(Timestamp t);

  /// The frame at `t` (camera clock) after one with the state `last`. If that one was only passing
  /// through, `passing` is its link to the newest keyframe, which goes on to this frame. Where
  /// `imu` cannot be used (not finite, not in order, not from end to end), constant velocity takes
  /// its place.
  PredictedFrame Next(const NavState& last,
                      std::optional<ImuLink> passing,
                      Timestamp t,
                      const ImuInterval& imu);

  /// What intervals are integrated with from here on.
  void SetGyroScale(const Vector3d& gyro_scale) { gyro_scale_ = gyro_scale; }

  /// One link for two intervals that follow each other.
  ImuLink Join(ImuLink first, const ImuLink& second) const;

  /// Integrates the links again whose biases or scale have moved too far for the first order.
  void Relinearize(SlidingWindow& window) const;

 private:
  void UpdateSqrtInfo(ImuLink& link) const;

  ImuParameters parameters_;
  BiasWalk bias_walk_;
  Duration time_offset_;
  Vector3d gyro_scale_ = Vector3d::Zero();
  Timestamp end_;  // of the newest interval, by the clock of the IMU
};

}  // namespace facet
