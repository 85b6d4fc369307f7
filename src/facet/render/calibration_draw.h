// SPDX-License-Identifier: BSD-2-Clause
// Which calibration a sequence is written with.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "facet/calibration/drawn_calibration.h"
#include "facet/imu/imu_types.h"

namespace facet {

/// What `facet simulate --draw-calibration` asks for.
struct CalibrationDraw {
  std::optional<std::uint64_t> seed;  ///< empty: the exact calibration is written
  DrawnParts parts;
  DrawnCalibrationOptions options;
};

/// The calibration to be written for the exact one. Throws ConfigError where none can be drawn.
StereoRig WrittenCalibration(const StereoRig& exact, const CalibrationDraw& draw);

/// The errors that the IMU has, which the written calibration does not know; none if none are
/// drawn.
std::optional<ImuErrors> UnknownImuErrors(const CalibrationDraw& draw);

/// What an IMU with these errors reads, biases and noise included.
void AddImuErrors(const ImuErrors& errors, std::vector<ImuSample>& samples);

/// Of a gyroscope that had the scale `before`.
Vector3d GyroScaleWith(const ImuErrors& errors, const Vector3d& before);

}  // namespace facet
