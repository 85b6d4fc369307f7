// SPDX-License-Identifier: BSD-2-Clause
// What to believe after the IMU and the images have contradicted each other. One of them was wrong:
// something large moves in front of the cameras, or a sensor lies for a moment. Which one cannot be
// told in time, so that from then on the state is uncertain by what they differed in.
#pragma once

#include <optional>

#include "facet/estimator/window/imu_link.h"

namespace facet {

/// IMU and images contradict each other beyond this (ImuErrorSigma of a keyframe). What it finds
/// and where it is wrong: docs/notebook/faults.md, from "A blind set of ten faults" on.
inline constexpr double kContradictionSigma = 4;

/// Not thread-safe.
class Contradiction {
 public:
  /// After the solve of a keyframe: its interval of the IMU and the states at its two ends.
  /// `error_sigma`: how far they are from each other (ImuErrorSigma).
  void Add(const ImuLink& link, const NavState& begin, const NavState& end, double error_sigma);

  /// What the differences so far have added up to at this time, of theta p v b_g b_a in the world
  /// of the state. A wrong velocity moves on, and is forgotten within some seconds; where it has
  /// led to is not.
  Matrix<15, 15> CovarianceAt(Timestamp t) const;

  /// Whether it is so new that the state is not to be trusted.
  bool IsRecentAt(Timestamp t) const;

 private:
  Vector3d PositionAt(double seconds_later) const;

  std::optional<Timestamp> t_;  // of the last contradiction
  Vector3d theta_ = Vector3d::Zero(), p_ = Vector3d::Zero(), v_ = Vector3d::Zero();
};

}  // namespace facet
