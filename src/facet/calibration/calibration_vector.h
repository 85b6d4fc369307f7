// SPDX-License-Identifier: BSD-2-Clause
// Everything that a calibration says about cameras and IMU, as one vector of 52 deviations from it
// (docs/math.md, section 10.1): the 22 parameters of lenses and stereo pair (RigVector), ten modes
// of the left and of the right lens (LensModes) [px], the mount (rotation and translation of both
// cameras on the body), the time offset [s], and by what share the gyroscope reads too much on each
// of its axes.
#pragma once

#include <array>
#include <string>

#include "facet/calibration/rig_parameters.h"

namespace facet {

/// The names of the parameters in files.
inline constexpr std::array<const char*, kNumCalibration> kCalibrationNames = {
    "cam0_fx",           "cam0_fy",           "cam0_cx",           "cam0_cy",
    "cam0_d0",           "cam0_d1",           "cam0_d2",           "cam0_d3",
    "cam1_fx",           "cam1_fy",           "cam1_cx",           "cam1_cy",
    "cam1_d0",           "cam1_d1",           "cam1_d2",           "cam1_d3",
    "stereo_rotation_x", "stereo_rotation_y", "stereo_rotation_z", "stereo_x",
    "stereo_y",          "stereo_z",          "cam0_mode0",        "cam0_mode1",
    "cam0_mode2",        "cam0_mode3",        "cam0_mode4",        "cam0_mode5",
    "cam0_mode6",        "cam0_mode7",        "cam0_mode8",        "cam0_mode9",
    "cam1_mode0",        "cam1_mode1",        "cam1_mode2",        "cam1_mode3",
    "cam1_mode4",        "cam1_mode5",        "cam1_mode6",        "cam1_mode7",
    "cam1_mode8",        "cam1_mode9",        "mount_rotation_x",  "mount_rotation_y",
    "mount_rotation_z",  "mount_x",           "mount_y",           "mount_z",
    "time_offset",       "gyro_scale_x",      "gyro_scale_y",      "gyro_scale_z"};

using CalibrationVector = Vector<kNumCalibration>;
using CalibrationMatrix = Matrix<kNumCalibration, kNumCalibration>;

/// The modes of one camera.
inline auto LensModesOf(CalibrationVector& v, int camera) {
  return v.segment<kNumLensModes>(kLensModes + camera * kNumLensModes);
}
inline auto LensModesOf(const CalibrationVector& v, int camera) {
  return v.segment<kNumLensModes>(kLensModes + camera * kNumLensModes);
}

/// How far `to` is from `from`, whose models of distortion are the same.
CalibrationVector CalibrationDifference(const StereoRig& from, const StereoRig& to);

/// A covariance whose variances of all modes of the lenses are zero says nothing of them: it is of
/// a run that did not estimate them.
void ForgetLensModes(CalibrationMatrix& covariance);
bool SaysNothingOfLensModes(const CalibrationMatrix& covariance);

/// 1-sigma of a parameter that a run holds, in its unit: far below what anything can measure.
inline constexpr double kHeldSigma = 1e-7;

/// Whether so many parameters from `first` on were held by the run that wrote the covariance: it
/// says nothing of how well they are known.
bool AreHeld(const CalibrationMatrix& covariance, int first, int count);

/// Why the matrix can be no covariance of a calibration, for a message; empty if it can: it has to
/// be symmetric and positive definite, with standard deviations from 1e-9 (in any unit) to 1000 px,
/// 10 m, 3 rad, 1 s and, of coefficients of distortion, a million.
std::string WhatIsWrong(const CalibrationMatrix& covariance);

}  // namespace facet
