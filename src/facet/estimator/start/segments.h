// SPDX-License-Identifier: BSD-2-Clause
// A run consists of segments: within one the estimator knows how all of it lies together; between
// two the state was lost. A new segment begins where the IMU alone has led to meanwhile, and all of
// it is as uncertain as that is.
#pragma once

#include <optional>

#include "facet/estimator/window/dead_reckoning.h"

namespace facet {

/// Not thread-safe.
class Segments {
 public:
  explicit Segments(const BiasWalk& walk) : walk_(walk) {}

  /// Of the newest state; counts from 0.
  int id() const { return id_; }

  /// The state was known once and is not now.
  bool is_between() const { return is_between_; }

  /// A keyframe whose state is good; `covariance` as the estimator has it, within the segment.
  /// `is_seen`: landmarks say where it is, not the IMU alone.
  void Keep(const NavState& x, const Matrix<15, 15>& covariance, bool is_seen);

  /// The position of a keyframe without landmarks is so uncertain that what comes next would not
  /// fit to what was there.
  bool HasDriftedAway(const NavState& x, const Matrix<15, 15>& covariance) const;

  /// The state is lost with the frame that `link` leads to, from the keyframe before (null: no
  /// link).
  void End(const ImuLink* link);

  /// Between segments: one more frame has come.
  void Follow(const ImuLink& link);

  /// Where the newest frame is: between segments by dead reckoning; empty if nothing was ever
  /// known.
  std::optional<SE3> PredictedPose() const;

  /// The state from which frames are predicted between segments.
  const NavState& reckoned() const { return reckoned_.x; }

  /// The start has put its newest frame at PredictedPose, or wherever it liked if that was empty.
  void Begin(const NavState& newest);

  /// The covariance of a state in W: that of the segment's place and heading comes on top.
  Matrix<15, 15> InWorld(const Matrix<15, 15>& covariance, const NavState& x) const;

 private:
  BiasWalk walk_;
  int id_ = -1;
  bool is_between_ = false;
  ReckonedState reckoned_;  ///< the newest good keyframe; between segments, the newest frame
  double seen_sigma_p_m_ = 0;
  Vector3d origin_ = Vector3d::Zero();                           ///< where the segment began, in W
  Eigen::Matrix4d origin_covariance_ = Eigen::Matrix4d::Zero();  ///< x, y, z, heading
};

}  // namespace facet
