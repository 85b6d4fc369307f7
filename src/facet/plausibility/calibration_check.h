// SPDX-License-Identifier: BSD-2-Clause
// Recognises calibrations that are grossly wrong: units or axes of the IMU, extrinsics the wrong
// way round. No estimator takes part, for one that starts with such a calibration is lost. Smaller
// errors are its business (calibration/calibration_deviation.h).
#pragma once

#include <optional>
#include <string>

#include "facet/camera/stereo_rig.h"
#include "facet/imu/imu_buffer.h"
#include "facet/plausibility/gyroscope_check.h"
#include "facet/plausibility/image_rotation.h"
#include "facet/plausibility/specific_force_check.h"

namespace facet {

/// Not thread-safe. Works only as long as something is left to be learnt and the body turns: a few
/// seconds at the begin of a usual recording.
class CalibrationCheck {
 public:
  explicit CalibrationCheck(const StereoRig& rig);

  /// After every frame, with the IMU since the frame before. `left`: null if the image cannot be
  /// used or is repeated; otherwise `previous` is the image of the last frame whose image could.
  /// Returns why the calibration cannot be right and what to do, once; otherwise empty. Never
  /// changes its mind.
  std::string Add(const PyramidPair* left, const ImuInterval& imu);

  /// Nothing more is to be learnt, or too much was tried.
  bool IsDone() const { return is_decided_; }
  int num_followed() const { return num_followed_; }  ///< images since the beginning

 private:
  std::string FromImages(const PyramidPair* left, const ImuInterval& imu);
  std::string EndTurn();

  std::optional<ImageRotation> images_;  ///< until nothing more is to be learnt from them
  GyroscopeCheck gyroscope_;
  SpecificForceCheck specific_force_;
  bool is_decided_ = false;
  bool is_following_ = false;
  int num_followed_ = 0;
  SharedTurn turn_;
};

}  // namespace facet
