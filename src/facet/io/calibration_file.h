// SPDX-License-Identifier: BSD-2-Clause
// Camera and IMU calibration from the two kinds of files that are in use.
//
// EuRoC: one sensor.yaml per sensor; T_BS maps the sensor to the body.
// Kalibr: camchain.yaml with T_cam_imu, which maps the IMU to the camera (the inverse), T_cn_cnm1,
// which maps the previous camera to this one (where T_cam_imu is given, too, it is compared only),
// and timeshift_cam_imu; and imu.yaml with the noise densities. OpenVINS's T_imu_cam (camera to
// IMU) is understood too. Our body is the IMU, whatever the file says.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "facet/camera/stereo_rig.h"
#include "facet/imu/imu_types.h"

namespace facet {

struct Calibration {
  StereoRig rig;
  ImuNoise imu_noise;
  std::string source;  ///< which files and which convention were read, for the log
  std::vector<std::string> warnings;
};

/// Paths of calibration files; an empty one means "in the sequence".
struct CalibrationFiles {
  /// Kalibr's camchain, Basalt's calibration.json, or a folder with cam0/sensor.yaml (EuRoC).
  std::filesystem::path cameras;
  std::filesystem::path imu;  ///< Kalibr imu.yaml or EuRoC sensor.yaml of the IMU
};

/// Throws InputError for cameras at the same place, or more than 10 m apart. `file`: for the
/// message.
void CheckBaseline(const StereoRig& rig, const std::string& file);

/// For Calibration::source.
std::string TimeOffsetText(Duration offset);

/// mav0/cam0/sensor.yaml, mav0/cam1/sensor.yaml and the IMU's noise. An empty `imu_file` means
/// mav0/imu0/sensor.yaml; where that is missing, the noise is the built-in one (ADIS16448), with a
/// warning.
Calibration ReadEurocCalibration(const std::filesystem::path& mav0,
                                 const std::filesystem::path& imu_file);

/// An empty `imu_file` leaves the noise at the built-in values (ADIS16448), with a warning.
Calibration ReadKalibrCalibration(const std::filesystem::path& camchain,
                                  const std::filesystem::path& imu_file);

/// Uses `files` where given; otherwise the sensor.yaml files of `mav0`, or else camchain*.yaml and
/// imu*.yaml in `mav0`, its parent or the parent's `dso` folder (TUM-VI).
///
/// All of these throw InputError with file and line for missing files and keys, unknown models,
/// matrices that are not rigid motions, numbers that are not finite, impossible intrinsics or
/// noise, and a baseline of nothing or above 10 m.
Calibration FindCalibration(const std::filesystem::path& mav0, const CalibrationFiles& files);

/// For recordings of other kinds: uses `files` where given, otherwise camchain*.yaml and imu*.yaml
/// in `folder`; empty if there are none. Throws InputError as FindCalibration does.
std::optional<Calibration> FindCalibrationBeside(const std::filesystem::path& folder,
                                                 const CalibrationFiles& files);

}  // namespace facet
