// SPDX-License-Identifier: BSD-2-Clause
// Recognises an IMU, or an accelerometer, that has never measured anything: it sends one value from
// its first sample on. A sensor that stops later has shown its noise before (imu/imu_screen.h).
#pragma once

#include <optional>
#include <span>
#include <string>
#include <unordered_map>

#include "facet/imu/imu_types.h"
#include "facet/map/observation.h"

namespace facet {

/// Not thread-safe. A simulated sensor without noise sends one value, too, while it is at rest; it
/// is left alone as long as the value is gravity's and the images stand still.
class DeadImuCheck {
 public:
  /// After every frame, with the IMU since the frame before (the first sample is the last one of
  /// the call before) and the features of the frame. What is wrong and what to do, in words, once;
  /// otherwise empty.
  std::string Add(std::span<const ImuSample> imu, std::span<const FeatureObservation> features);

 private:
  void AddImu(std::span<const ImuSample> imu);
  void AddImages(std::span<const FeatureObservation> features);
  std::string InWords() const;

  bool is_decided_ = false;
  std::optional<ImuSample> first_, newest_;
  bool gyro_lives_ = false;
  std::unordered_map<LandmarkId, Vector2d> reference_px_;  // places of landmarks in an older frame
  bool images_move_ = false;
};

}  // namespace facet
