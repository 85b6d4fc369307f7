// SPDX-License-Identifier: BSD-2-Clause
#include "facet/live/imu_step.h"

#include <cmath>

#include "facet/base/check.h"
#include "facet/geometry/so3.h"

namespace facet {

namespace {

struct StepJacobians {
  Matrix<9, 9> A = Matrix<9, 9>::Identity();  // d (theta p v) / d (theta p v)
  Matrix<9, 6> B;                             // d (theta p v) / d (mean rate, mean acceleration)
};

// Variance of the mean measurement over the step, as in ImuPreintegration.
Vector<6> MeasurementVariance(const ImuSample& b, double dt, bool is_hole, const ImuParameters& p) {
  Vector<6> variance;
  variance.head<3>().setConstant(p.gyro * p.gyro / dt +
                                 (is_hole ? p.gyro_in_gap * p.gyro_in_gap : 0));
  variance.tail<3>().setConstant(p.accel * p.accel / dt +
                                 (is_hole ? p.accel_in_gap * p.accel_in_gap : 0));
  variance.head<3>() += b.gyro_doubt.cwiseAbs2();
  variance.tail<3>() += b.accel_doubt.cwiseAbs2();
  return variance;
}

// The biases enter as the measurements do, with the other sign, and stay: only their blocks with
// the rest change, and their walk is added.
void AdvanceCovariance(const StepJacobians& J,
                       const Vector<6>& variance,
                       double dt,
                       const BiasWalk& walk,
                       Matrix<15, 15>& covariance) {
  const Matrix<9, 9> P_xx = covariance.topLeftCorner<9, 9>();
  const Matrix<9, 6> P_xb = covariance.topRightCorner<9, 6>();
  const Matrix<6, 6> P_bb = covariance.bottomRightCorner<6, 6>();
  const Matrix<9, 6> new_xb = J.A * P_xb - J.B * P_bb;
  const Matrix<9, 9> half = J.A * P_xx - J.B * P_xb.transpose();
  const Matrix<9, 6> noise_B = J.B * variance.asDiagonal();
  const Matrix<9, 9> new_xx = half * J.A.transpose() + (noise_B - new_xb) * J.B.transpose();
  covariance.topLeftCorner<9, 9>() = 0.5 * (new_xx + new_xx.transpose());
  covariance.topRightCorner<9, 6>() = new_xb;
  covariance.bottomLeftCorner<6, 9>() = new_xb.transpose();
  covariance.diagonal().segment<3>(9).array() += walk.gyro * walk.gyro * dt;
  covariance.diagonal().segment<3>(12).array() += walk.accel * walk.accel * dt;
}

}  // namespace

Vector3d RateOf(const ImuSample& sample, const ImuBias& bias, const Vector3d& gyro_scale) {
  return sample.gyro - gyro_scale.cwiseProduct(sample.gyro) - bias.b_g;
}

void Advance(const ImuSample& a, const ImuSample& b, const StepModel& model, ReckonedState& state) {
  FACET_CHECK(b.t >= a.t) << "sample at " << b.t.ns << " after one at " << a.t.ns;
  const double dt = ToSeconds(b.t - a.t);
  NavState& x = state.x;
  x.t = b.t;
  if (dt == 0) return;
  const Vector3d w =
      0.5 * (RateOf(a, x.bias, model.gyro_scale) + RateOf(b, x.bias, model.gyro_scale));
  const Vector3d a0 = a.accel - x.bias.b_a, a1 = b.accel - x.bias.b_a;
  const Quaterniond q_step = ExpSO3(w * dt);
  const Quaterniond q_end = (x.T_WB.q * q_step).normalized();
  const Matrix3d R_step_T = q_step.toRotationMatrix().transpose();
  const Matrix3d R0 = x.T_WB.R(), R1 = q_end.toRotationMatrix();
  const Vector3d acceleration = 0.5 * (R0 * a0 + R1 * a1) + model.parameters.g_W();

  const Matrix3d J_theta_w = RightJacobianSO3(w * dt) * dt;
  const Matrix3d half_R1_hat = 0.5 * R1 * Hat(a1);
  const Matrix3d J_acc_theta = -0.5 * R0 * Hat(a0) - half_R1_hat * R_step_T;
  const Matrix3d J_acc_w = -half_R1_hat * J_theta_w;
  const Matrix3d J_acc_a = 0.5 * (R0 + R1);
  StepJacobians J;
  J.A.block<3, 3>(0, 0) = R_step_T;
  J.A.block<3, 3>(3, 0) = 0.5 * dt * dt * J_acc_theta;
  J.A.block<3, 3>(3, 6) = dt * Matrix3d::Identity();
  J.A.block<3, 3>(6, 0) = dt * J_acc_theta;
  J.B.block<3, 3>(0, 0) = J_theta_w;
  J.B.block<3, 3>(0, 3).setZero();
  J.B.block<3, 3>(3, 0) = 0.5 * dt * dt * J_acc_w;
  J.B.block<3, 3>(3, 3) = 0.5 * dt * dt * J_acc_a;
  J.B.block<3, 3>(6, 0) = dt * J_acc_w;
  J.B.block<3, 3>(6, 3) = dt * J_acc_a;

  const ImuParameters& parameters = model.parameters;
  const bool is_hole = dt > model.max_step_s;
  AdvanceCovariance(
      J, MeasurementVariance(b, dt, is_hole, parameters), dt, model.walk, state.covariance);
  // Inside a hole the acceleration may also have come early or late.
  const double sigma_p_hole = is_hole ? parameters.accel_in_gap * dt * dt / std::sqrt(12.0) : 0;
  state.covariance.diagonal().segment<3>(3).array() +=
      parameters.integration * parameters.integration * dt + sigma_p_hole * sigma_p_hole;

  x.T_WB.p += x.v_WB * dt + 0.5 * dt * dt * acceleration;
  x.v_WB += dt * acceleration;
  x.T_WB.q = q_end;
}

}  // namespace facet
