// SPDX-License-Identifier: BSD-2-Clause
// Whether images and IMU move alike: how far, by the accelerometer (ScaleCheck), and by how much
// they turn (TurnCheck). How far the images move is known in two ways: by the stereo pair alone,
// which takes seconds and knows nothing of the accelerometer, and by the states of the estimator,
// which are more exact where all is far away.
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
  explicit MotionCheck(const StereoRig& rig) : images_(rig), baseline_m_(rig.baseline_m()) {}

  /// See ScaleCheck.
  void DistrustAccelerometer();

  /// States from before and after this are not to be compared. Images still are.
  void LoseState() { by_states_.Break(); }

  /// The estimator has another calibration: sizes of before are of no use.
  void WorldHasChanged();

  /// The calibration as the estimator has it, whenever that may have changed.
  void SetRig(const StereoRig& rig);

  /// The IMU from the end of the interval before.
  void AddImu(const ImuInterval& imu);

  /// A keyframe at the end of the last interval, and the estimator's state there; null: it has
  /// none. The graver finding of both ways; a doubt is told once.
  ScaleCheck::Finding AddKeyframe(const FrameObservations& seen, const NavState* state);

  /// The images do not turn as the gyroscope says: after the keyframe that makes it certain, once.
  std::optional<TurnCheck::Ratio> TakeDoubtOfTurns();

  const std::optional<TurnCheck::Ratio>& turns() const { return turns_.ratio(); }

  /// Of the world, by the way that knows it better.
  const std::optional<ScaleCheck::Scale>& scale() const;
  /// The way that the last finding was of.
  const ScaleCheck& found_by() const { return is_by_images_ ? by_images_ : by_states_; }

 private:
  ScaleCheck::Finding FollowImages(const FrameObservations& seen);

  StereoMotion images_;
  double baseline_m_;
  ScaleCheck by_images_, by_states_;
  TurnCheck turns_;
  std::optional<ImuBias> bias_;  // as last known
  bool is_by_images_ = false, has_doubted_ = false, has_doubted_turns_ = false;
};

}  // namespace facet
