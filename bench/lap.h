// SPDX-License-Identifier: BSD-2-Clause
// A sequence whose end joins its beginning, so that it can be played again and again.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "facet/imu/imu_types.h"

namespace facet {

/// Stamps of the images and samples of the IMU in one lap, repeated for ever. Not thread-safe.
class Lap {
 public:
  /// All sorted by time. `truth` has poses and biases at the samples of the IMU. Samples before the
  /// first frame and after the lap are left out, and all biases become `bias`, for a bias that
  /// drifts would jump where the lap begins again; empty: those of the first frame. Throws
  /// InputError if the motion does not return to where it began, or the truth has no biases.
  Lap(std::span<const Timestamp> frames,
      std::span<const ImuSample> imu,
      std::span<const NavState> truth,
      const std::optional<ImuBias>& bias = {});

  int num_frames() const { return static_cast<int>(frames_.size()); }
  Duration period() const { return period_; }
  const ImuBias& bias() const { return bias_; }
  Timestamp FrameStamp(int lap, int frame) const;
  /// The samples from the lap's first frame until the first frame of the next lap, exclusively.
  std::vector<ImuSample> ImuOf(int lap) const;

 private:
  std::vector<Timestamp> frames_;
  std::vector<ImuSample> imu_;
  ImuBias bias_;
  Duration period_;
};

}  // namespace facet
