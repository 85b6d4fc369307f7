// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/estimator_result.h"

#include <cmath>

namespace facet {

namespace {

constexpr int kMinLandmarksOk = 8;
// Beyond these the state is of no use: start again.
constexpr double kLostVelocitySigma = 5.0;  // m/s
constexpr double kLostSpeed = 100.0;        // m/s

bool IsFinite(const NavState& x) {
  return x.T_WB.p.allFinite() && x.T_WB.q.coeffs().allFinite() && x.v_WB.allFinite() &&
         x.bias.b_g.allFinite() && x.bias.b_a.allFinite();
}

}  // namespace

void SetState(const NavState& state,
              const Matrix<15, 15>& covariance,
              int num_constraining,
              bool has_imu,
              EstimatorResult& result) {
  result.has_state = true;
  result.state = state;
  result.covariance = covariance;
  result.num_constraining = num_constraining;
  result.status = TrackingStatus::kOk;
  result.reason.clear();
  if (num_constraining < kMinLandmarksOk) {
    result.status = TrackingStatus::kDegraded;
    result.reason = "few landmarks";
  } else if (!has_imu) {
    result.status = TrackingStatus::kDegraded;
    result.reason = "no IMU";
  }
  const double velocity_sigma = std::sqrt(covariance.block<3, 3>(6, 6).trace());
  const bool is_sane = IsFinite(state) && covariance.allFinite();
  if (!is_sane || !(velocity_sigma < kLostVelocitySigma) || state.v_WB.norm() > kLostSpeed) {
    SetLost(is_sane ? "velocity unknown" : "numerical failure", result);
  }
}

void SetLost(const char* reason, EstimatorResult& result) {
  result.status = TrackingStatus::kLost;
  result.reason = reason;
  result.has_state = false;
}

}  // namespace facet
