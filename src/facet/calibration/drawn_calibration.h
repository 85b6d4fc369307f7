// SPDX-License-Identifier: BSD-2-Clause
// What a careful calibration would have written instead of the exact one.
#pragma once

#include <cstdint>
#include <optional>

#include "facet/base/options.h"
#include "facet/base/random.h"
#include "facet/calibration/board_calibration.h"

namespace facet {

/// Which parts of a calibration are drawn; the others stay exact. A part is the same whether the
/// others are drawn or not.
struct DrawnParts {
  bool lens = true;   ///< intrinsics of both cameras and the transform between them
  bool imu = true;    ///< where both cameras are in the body
  bool time = true;   ///< clock of the cameras against that of the IMU
  bool scale = true;  ///< of the IMU's axes, and their misalignment
};

/// 1-sigma; of the mount of the length of the errors.
struct DrawnCalibrationOptions {
  BoardCalibrationOptions board;
  double imu_rotation_deg = 0.1;
  double imu_translation_m = 3e-3;
  double time_s = 1e-3;
  double imu_scale_percent = 0.3;      ///< each axis of both sensors
  double imu_misalignment_deg = 0.05;  ///< each axis of both sensors, towards each other one

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field(
        "corner_noise_px", board.corner_noise_px, Range{0, 20}, "1-sigma, corners of the board");
    v.Field(
        "misfit_share", board.misfit_share, Range{0, 20}, "what the lens model cannot say, to it");
    v.Field("imu_rotation_deg", imu_rotation_deg, Range{0, 10}, "1-sigma, cameras against IMU");
    v.Field("imu_translation_m", imu_translation_m, Range{0, 1}, "1-sigma, cameras against IMU");
    v.Field("time_s", time_s, Range{0, 0.1}, "1-sigma, clock of the cameras");
    v.Field("imu_scale_percent", imu_scale_percent, Range{0, 10}, "1-sigma, axes of the IMU");
    v.Field("imu_misalignment_deg", imu_misalignment_deg, Range{0, 5}, "1-sigma, axes of the IMU");
  }
};

/// The calibration of another careful person with each seed. Lens errors come from
/// CalibrateWithBoard, so that they go together as those of a real calibration do. The left
/// camera's place in the body has the error of camera against IMU alone: what the principal point
/// is off is not made up for by a turn of the camera. Empty if no board can be calibrated with
/// (MakeUpBoardViews, CalibrateWithBoard).
std::optional<StereoRig> DrawCalibration(const StereoRig& exact,
                                         std::uint64_t seed,
                                         const DrawnParts& parts = {},
                                         const DrawnCalibrationOptions& options = {});

/// By what the readings of an IMU are multiplied, beside what a calibration knows: scales of the
/// axes, and axes that are not where the body's are.
struct ImuErrors {
  Matrix3d of_gyro = Matrix3d::Identity();
  Matrix3d of_accel = Matrix3d::Identity();
};

/// 1-sigma of every element: scales, and axes that are not quite orthogonal.
ImuErrors DrawImuErrors(double scale_percent, double misalignment_deg, Rng& rng);

/// The errors of the IMU that belongs to DrawCalibration with the same seed: a calibration does not
/// know them.
ImuErrors DrawImuErrors(std::uint64_t seed, const DrawnCalibrationOptions& options = {});

}  // namespace facet
