// SPDX-License-Identifier: BSD-2-Clause
// Calibrations as Basalt writes and reads them (calibration.json): cameras, where they are on the
// IMU, the time offset and the noise of the IMU in one file.
#pragma once

#include <filesystem>

#include "facet/io/calibration_file.h"

namespace facet {

/// Of the first two cameras. Models: pinhole, pinhole-radtan8, kb4, ds, eucm, ucm, fov. `imu_file`
/// (Kalibr's or EuRoC's) goes before the noise in the file; the calibrated biases are not used.
/// Throws InputError with the file and the name of the entry.
Calibration ReadBasaltCalibration(const std::filesystem::path& file,
                                  const std::filesystem::path& imu_file);

}  // namespace facet
