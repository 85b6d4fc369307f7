// SPDX-License-Identifier: BSD-2-Clause
// The calibration that a run has estimated, as Kalibr's camchain-imucam.yaml.
#pragma once

#include <filesystem>
#include <string>

#include "facet/camera/stereo_rig.h"

namespace facet {

/// Kalibr's keys, `lens_modes` of a camera and `gyro_scale` if they are not zero, and `covariance`
/// with the names of the parameters and their matrix, if the rig has one. ReadKalibrCalibration
/// reads it back.
std::string CalibrationYaml(const StereoRig& rig);

/// Throws OutputError naming the file.
void WriteCalibration(const std::filesystem::path& file, const StereoRig& rig);

}  // namespace facet
