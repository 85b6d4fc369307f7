// SPDX-License-Identifier: BSD-2-Clause
// What the doubt about the size of the world, and of turns, adds to the covariance of the state. An
// estimator that believes its calibration knows positions no better than that calibration is right,
// and some calibrations are not what they claim: until the accelerometer has confirmed the size of
// the world, and where it contradicts it, each way that was flown may be longer or shorter, and
// where the gyroscope contradicts the images each turn (docs/math.md, section 10.8).
#pragma once

#include <optional>
#include <vector>

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

/// Variance of the relative error of turns, and the probability that they are wrong.
struct TurnDoubt {
  double variance = 0, share_wrong = 0;
};
TurnDoubt DoubtOfTurns(const std::optional<TurnCheck::Ratio>& turns);

/// Not thread-safe.
class SizeDoubt {
 public:
  /// After each keyframe that has a pose.
  void AddKeyframe(const NavState& x,
                   const std::optional<ScaleCheck::Scale>& scale,
                   const std::optional<TurnCheck::Ratio>& turns);

  /// How the body turned until the next keyframe with a pose was not seen.
  void LoseState() { is_lost_ = true; }

  /// The estimator has another calibration from the last keyframe on.
  void WorldHasChanged();

  /// Of theta p v b_g b_a, beside the estimator's own.
  Matrix<15, 15> CovarianceOf(const NavState& x) const;

 private:
  /// Sums over the way so far.
  struct Reached {
    SE3 T_WB;
    double heading_rad = 0;                    // of all turns about the vertical
    Vector3d turned_way_W = Vector3d::Zero();  // of ways, each times the heading there [rad m]
  };
  /// By turns that were wrong until the calibration changed.
  struct Astray {
    double variance = 0;
    double heading_rad = 0;
    Vector3d turned_way_W = Vector3d::Zero();
    Vector3d p_W = Vector3d::Zero();  // where it changed
  };

  Reached ReachedAt(const SE3& T_WB) const;
  Astray AstrayAt(const Reached& now) const;

  std::optional<Reached> since_;  // where the calibration became what it is
  std::optional<Reached> last_;
  bool is_lost_ = false, are_turns_doubted_ = false;
  double size_variance_ = 0, turn_variance_ = 0;
  // By calibrations that were changed.
  Matrix3d astray_ = Matrix3d::Zero();  // by sizes: positions [m^2]
  std::vector<Astray> turned_astray_;
};

}  // namespace facet
