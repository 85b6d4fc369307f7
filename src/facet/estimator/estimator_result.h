// SPDX-License-Identifier: BSD-2-Clause
// What the back end says after a frame.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "facet/estimator/bias_watch.h"
#include "facet/estimator/solver/window_solver.h"
#include "facet/imu/causal_state.h"
#include "facet/imu/imu_types.h"
#include "facet/map/map_snapshot.h"
#include "facet/map/tracking_status.h"

namespace facet {

struct EstimatorResult {
  TrackingStatus status = TrackingStatus::kInitialising;
  std::string reason;      ///< why the status is not kOk, or empty
  bool has_state = false;  ///< false while initialising, and where it is lost
  int segment = 0;         ///< of the state; see Segments
  NavState state;          ///< causal estimate of this frame
  /// Theta p v b_g b_a; of the smoother (docs/math.md, section 4.7).
  Matrix<15, 15> covariance = Matrix<15, 15>::Zero();
  /// The same as the smoother itself believes it, with its noise and calibration.
  Matrix<15, 15> solved_covariance = Matrix<15, 15>::Zero();
  CausalState causal;        ///< state and `covariance` for whoever goes on with the IMU
  int num_constraining = 0;  ///< landmarks that constrain the window and are seen in this frame
  bool was_reset = false;    ///< the state was given up after this frame; the next one starts again
  SolveSummary solve;
  /// Keyframes with an IMU interval: how far it is from the solved window (see ImuErrorSigma).
  std::optional<double> imu_error_sigma;
  /// As of the newest keyframe: a bias changes faster than a sensor's does.
  std::optional<BiasDrift> bias_drift;
  /// Keyframes that left the window, with their final poses.
  std::vector<KeyframePose> finished_keyframes;
};

/// Fills in the state, and judges it: kOk, kDegraded, or kLost if it is of no use to anybody.
/// `num_constraining`: landmarks that say where the frame is; `has_imu`: since the frame before.
void SetState(const NavState& state,
              const Matrix<15, 15>& covariance,
              int num_constraining,
              bool has_imu,
              EstimatorResult& result);

/// The state is of no use to anybody.
void SetLost(const char* reason, EstimatorResult& result);

}  // namespace facet
