// SPDX-License-Identifier: BSD-2-Clause
// Whether the accelerometer can be in m/s^2: over some seconds its mean is gravity, whatever the
// body does.
#pragma once

#include <span>
#include <string>

#include "facet/imu/imu_types.h"

namespace facet {

/// Not thread-safe.
class SpecificForceCheck {
 public:
  /// What is wrong, in words, with the samples that complete the stretch; otherwise empty. The
  /// first sample is the last one of the call before.
  std::string Add(std::span<const ImuSample> samples);

  /// A stretch was long enough and as it should be.
  bool IsConvinced() const { return is_convinced_; }

 private:
  double duration_s_ = 0;
  double integral_ = 0;  // of the magnitude
  bool is_convinced_ = false;
};

}  // namespace facet
