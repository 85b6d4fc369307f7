// SPDX-License-Identifier: BSD-2-Clause
// The parts that EuRoC's and Kalibr's calibration files have in common.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "facet/camera/stereo_rig.h"
#include "facet/imu/imu_types.h"
#include "facet/io/yaml_file.h"

namespace facet {

/// A rigid motion from a 4x4 (or 3x4) matrix: nested rows, a flat list, or OpenCV's {rows, cols,
/// data}.
SE3 ReadRigid(const YamlFile& yaml, const YAML::Node& parent, const std::string& key);

/// Resolution, camera_model, intrinsics and distortion (lens_yaml.h).
CameraModel ReadCamera(const YamlFile& yaml, const YAML::Node& camera);

/// The `lens_modes` that a run has written with a camera [px]; zero if there are none.
LensModeVector ReadLensModes(const YamlFile& yaml, const YAML::Node& camera);

/// What a calibration may say of a scale is less than this share.
inline constexpr double kMaxGyroScale = 0.2;

/// The `gyro_scale` that a run has written with its calibration; zero if there is none.
Vector3d ReadGyroScale(const YamlFile& yaml);

/// The `covariance` that a run has written with its calibration (calibration_writer.h), in the
/// order of CalibrationVector; null if there is none. One without the modes of the lenses says
/// nothing of them. Refuses what is no covariance of these parameters.
std::shared_ptr<const MatrixXd> ReadCovariance(const YamlFile& yaml);

/// The `axes_sigma` that a run has written with its covariance [rad]; zero if there is none.
double ReadAxesSigma(const YamlFile& yaml);

/// Noise densities at the root of the file or below `imu0`; warns of values that are off by
/// decades, and of missing ones, whose place those of an ADIS16448 take.
ImuNoise ReadImuNoise(const YamlFile& yaml, std::vector<std::string>& warnings);

}  // namespace facet
