// SPDX-License-Identifier: BSD-2-Clause
// Rotation between camera and IMU, time offset, scale and bias of the gyroscope, from turns that
// both see. No depths, no accelerometer.
#pragma once

#include <span>

#include "facet/check/gyro_turns.h"

namespace facet {

/// The camera turns by scale * R_CB * (what the gyroscope measured `tau_s` later - bias).
struct CameraImuModel {
  Quaterniond R_CB = Quaterniond::Identity();
  double log_scale = 0;
  Vector3d bias = Vector3d::Zero();  ///< [rad/s]
  double tau_s = 0;                  ///< t_imu = t_camera + tau
};

struct CameraImuFit {
  CameraImuModel model;
  /// Of the turn of R_CB against where the fit began (in the body), log_scale, bias, tau_s.
  Matrix<8, 8> covariance = Matrix<8, 8>::Identity();
  Vector3d turned = Vector3d::Zero();  ///< that turn [rad]
  int num_turns = 0;                   ///< with a gyroscope around them
  double cost = 0;                     ///< mean robust cost of a turn; about 1 to 3 where it fits

  double Sigma(int parameter) const;
  /// Of the turn of R_CB: its length in units of its uncertainty.
  double TurnedSigmas() const;
};

/// The time offset at which the angles of the turns agree best in size, whatever the mount, within
/// 0.5 s; zero where none is clearly better.
double RoughTimeOffset(std::span<const ImageTurn> turns, const GyroTrack& gyro);

/// Robust least squares from a start. Where the motion says nothing, parameters stay.
CameraImuFit FitCameraImu(std::span<const ImageTurn> turns,
                          const GyroTrack& gyro,
                          const CameraImuModel& start);

/// Time offset of some turns alone, all else as given: value and 1-sigma [s].
std::pair<double, double> FitTimeOffset(std::span<const ImageTurn> turns,
                                        const GyroTrack& gyro,
                                        const CameraImuModel& model);

}  // namespace facet
