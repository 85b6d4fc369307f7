// SPDX-License-Identifier: BSD-2-Clause
// What the doubt about the size of the world adds to the covariance of the state. An estimator
// that believes its calibration knows positions no better than that calibration is right, and some
// calibrations are not what they claim: until the accelerometer has confirmed the size of the
// world, and where it contradicts it, each way that was flown may be longer or shorter
// (docs/math.md, section 10.8).
#pragma once

#include <optional>

#include "facet/imu/imu_types.h"
#include "facet/plausibility/scale_check.h"
#include "facet/plausibility/turn_check.h"

namespace facet {

/// Variance of the relative error of lengths, by what the accelerometer says of the size so far
/// (ScaleCheck), and the gyroscope of turns (TurnCheck): few calibrations are wrong by far more
/// than they claim. Focal lengths that are wrong make ways along the optical axis too long and
/// others not, so that the size may be right in the mean.
double SizeVariance(const std::optional<ScaleCheck::Scale>& scale,
                    const std::optional<TurnCheck::Ratio>& turns);

/// Not thread-safe.
class SizeDoubt {
 public:
  /// After each keyframe that has a pose.
  void AddKeyframe(const NavState& x,
                   const std::optional<ScaleCheck::Scale>& scale,
                   const std::optional<TurnCheck::Ratio>& turns);

  /// The estimator has another calibration from the last keyframe on.
  void WorldHasChanged();

  /// Of theta p v b_g b_a, beside the estimator's own.
  Matrix<15, 15> CovarianceOf(const NavState& x) const;

 private:
  Vector3d WayTo(const Vector3d& p_W) const;

  std::optional<Vector3d> origin_;  // where the calibration became what it is
  Vector3d last_ = Vector3d::Zero();
  double variance_ = 0;
  Matrix3d astray_ = Matrix3d::Zero();  // of positions, by calibrations that were changed [m^2]
};

}  // namespace facet
