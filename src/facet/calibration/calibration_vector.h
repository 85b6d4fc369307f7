// SPDX-License-Identifier: BSD-2-Clause
// Everything that a calibration says about cameras and IMU, as one vector of 32 deviations from it
// (docs/math.md, section 10.1).
#pragma once

#include <array>
#include <string>

#include "facet/calibration/rig_parameters.h"

namespace facet {

/// Columns of the calibration: the 22 parameters of lenses and stereo pair (RigVector), then the
/// mount (rotation and translation of both cameras on the body), the time offset [s], and by what
/// share the gyroscope reads too much on each of its axes.
inline constexpr int kMountRotation = kNumRigParameters;
inline constexpr int kMountTranslation = kMountRotation + 3;
inline constexpr int kTimeOffset = kMountTranslation + 3;
inline constexpr int kGyroScale = kTimeOffset + 1;
inline constexpr int kNumCalibration = kGyroScale + 3;
/// Those that move the cameras of a frame as a whole, like its pose.
inline constexpr int kNumMount = kGyroScale - kNumRigParameters;

/// Their names in files.
inline constexpr std::array<const char*, kNumCalibration> kCalibrationNames = {
    "cam0_fx",           "cam0_fy",           "cam0_cx",           "cam0_cy",
    "cam0_d0",           "cam0_d1",           "cam0_d2",           "cam0_d3",
    "cam1_fx",           "cam1_fy",           "cam1_cx",           "cam1_cy",
    "cam1_d0",           "cam1_d1",           "cam1_d2",           "cam1_d3",
    "stereo_rotation_x", "stereo_rotation_y", "stereo_rotation_z", "stereo_x",
    "stereo_y",          "stereo_z",          "mount_rotation_x",  "mount_rotation_y",
    "mount_rotation_z",  "mount_x",           "mount_y",           "mount_z",
    "time_offset",       "gyro_scale_x",      "gyro_scale_y",      "gyro_scale_z"};

using CalibrationVector = Vector<kNumCalibration>;
using CalibrationMatrix = Matrix<kNumCalibration, kNumCalibration>;

/// How far `to` is from `from`, whose models of distortion are the same.
CalibrationVector CalibrationDifference(const StereoRig& from, const StereoRig& to);

/// Why the matrix can be no covariance, for a message; empty if it can.
std::string WhatIsWrong(const CalibrationMatrix& covariance);

}  // namespace facet
