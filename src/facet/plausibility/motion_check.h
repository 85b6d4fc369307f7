// SPDX-License-Identifier: BSD-2-Clause
// Whether images and IMU move alike: how far, by the accelerometer (ScaleCheck), and by how much
// they turn (TurnCheck). How far the images move is known in two ways: by the stereo pair alone,
// which takes seconds and asks the accelerometer nothing, and by the states of the estimator, which
// are more exact where all is far away.
#pragma once

#include <optional>

#include "facet/map/observation.h"
#include "facet/plausibility/scale_check.h"
#include "facet/plausibility/stereo_motion.h"
#include "facet/plausibility/turn_check.h"

namespace facet {

/// Not thread-safe.
class MotionCheck {
 public:
  explicit MotionCheck(const StereoRig& rig);

  /// See ScaleCheck.
  void DistrustAccelerometer();

  /// States from before and after this are not to be compared. Images still are.
  void LoseState() { by_states_.Break(); }

  /// The estimator begins to learn another calibration: sizes of before are of no use.
  void WorldHasChanged();

  /// The calibration as the estimator has it, whenever that may have changed. True where it makes
  /// the world another size than before, so that measuring the size begins anew.
  bool SetRig(const StereoRig& rig);

  /// The IMU from the end of the interval before.
  void AddImu(const ImuInterval& imu);

  /// A keyframe at the end of the last interval, and the estimator's state there; null: it has
  /// none. The graver finding of both ways; a doubt is told once.
  ScaleCheck::Finding AddKeyframe(const FrameObservations& seen, const NavState* state);

  /// With the given calibration the images do not turn as the gyroscope says. Once, after the
  /// keyframe that has made it certain.
  std::optional<TurnCheck::Ratio> TakeDoubtOfTurns();

  /// Of the given calibration; empty once the estimator has another one.
  std::optional<TurnCheck::Ratio> turns() const {
    return has_given_rig_ ? turns_.ratio() : std::nullopt;
  }

  /// Of the world: by images or states, whichever knows it better.
  const std::optional<ScaleCheck::Scale>& scale() const;
  /// The way that the last finding was of.
  const ScaleCheck& found_by() const { return was_found_by_images_ ? by_images_ : by_states_; }

 private:
  ScaleCheck::Finding AddImages(const FrameObservations& seen);
  void AddTurn(const FrameObservations& seen);

  StereoMotion motion_;        // with the calibration as the estimator has it
  StereoMotion given_motion_;  // with the one that was given
  double size_px_m_;           // by which sizes are proportional to depths of motion_
  bool has_given_rig_ = true;
  ScaleCheck by_images_, by_states_;
  TurnCheck turns_;
  std::optional<Vector3d> gyro_bias_;  // as last known
  bool was_found_by_images_ = false, has_doubted_ = false, has_doubted_turns_ = false;
};

}  // namespace facet
