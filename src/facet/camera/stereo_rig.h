// SPDX-License-Identifier: BSD-2-Clause
// The sensor rig: two cameras rigidly mounted on the body (= IMU).
#pragma once

#include <array>
#include <memory>

#include "facet/camera/camera_model.h"
#include "facet/camera/rig_columns.h"
#include "facet/geometry/se3.h"

namespace facet {

/// Amounts of the smooth fields that a lens has beside its model (calibration/lens_modes.h) [px].
using LensModeVector = Vector<kNumLensModes>;

struct StereoRig {
  std::array<CameraModel, 2> cameras;  ///< left, right
  /// What the lenses do beside their models [px]; not zero if a former run has estimated it.
  std::array<LensModeVector, 2> lens_modes = {LensModeVector::Zero(), LensModeVector::Zero()};
  std::array<SE3, 2> T_BC;  ///< camera to body
  /// t_imu = t_camera + time_offset (Kalibr's timeshift_cam_imu).
  Duration time_offset;
  /// By what share the gyroscope reads too much on each of its axes; not zero if a former run has
  /// estimated it.
  Vector3d gyro_scale = Vector3d::Zero();
  /// Of all this, in the order of CalibrationVector (calibration/calibration_vector.h); null: not
  /// known.
  std::shared_ptr<const MatrixXd> covariance;
  /// `covariance` is of the cameras against the axes of the gyroscope, which may be off those of
  /// the body by this much about each axis, 1-sigma [rad].
  double axes_sigma = 0;

  bool HasLensModes() const { return !lens_modes[0].isZero(0) || !lens_modes[1].isZero(0); }
  SE3 T_C1C0() const { return T_BC[1].Inverse() * T_BC[0]; }
  double baseline_m() const { return T_C1C0().p.norm(); }
};

}  // namespace facet
