// SPDX-License-Identifier: BSD-2-Clause
// What a controller gets, and in which coordinates.
#pragma once

#include "facet/imu/imu_types.h"
#include "facet/map/tracking_status.h"

namespace facet {

/// Axes of the world in which states are output. The world W of Facet has z up, its heading is that
/// of the first pose; nothing here knows where north is.
enum class WorldAxes {
  kEnu,  ///< W itself, as REP 103 has it
  kNed   ///< x and y of W exchanged, z down, as MAVROS turns the one into the other
};

/// A frame F that is fixed to the body, and the world in which it is told where it is.
struct OutputFrame {
  /// F to body: identity, where a robot's own base is, or StereoRig::T_BC[0] for the left camera.
  SE3 T_BF;
  WorldAxes world = WorldAxes::kEnu;
};

/// Where the frame F of an OutputFrame is at a moment between and after the stereo frames.
struct PredictedState {
  Timestamp t;                       ///< by the IMU's clock
  SE3 T_WF;                          ///< F to world
  Vector3d v_WF = Vector3d::Zero();  ///< of F's origin, in the world [m/s]
  Vector3d w_F = Vector3d::Zero();   ///< angular velocity, in F, without bias [rad/s]
  /// Acceleration of F's origin in the world, without gravity [m/s^2]. Where F is not the body,
  /// what an angular acceleration would add is left out: nothing measures it.
  Vector3d a_WF = Vector3d::Zero();
  ImuBias bias;  ///< in B, whatever F is
  /// Of theta (in F, on the right of the rotation), p and v (in the world), b_g and b_a (in B),
  /// with what the IMU has added since the newest frame. Of the estimate, without `held_back`.
  Matrix<15, 15> covariance = Matrix<15, 15>::Zero();
  TrackingStatus status = TrackingStatus::kInitialising;  ///< of the newest frame
  int segment = 0;       ///< of the newest frame with a pose; poses of two segments may be apart
  Duration since_frame;  ///< from the newest frame with a pose to t
  Duration since_imu;    ///< from the newest sample to t, for which that sample is held
  /// What smoothing holds back: the estimate is Exp(theta) on the right of this rotation, and p and
  /// v added to these. Zero without smoothing.
  Vector<9> held_back = Vector<9>::Zero();
};

/// The same state of another frame in another world. `state` is of the body in W.
PredictedState InFrame(const PredictedState& state, const OutputFrame& frame);

}  // namespace facet
