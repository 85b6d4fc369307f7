// SPDX-License-Identifier: BSD-2-Clause
#include "facet/live/imu_step.h"

#include <cmath>

#include "facet/base/check.h"

namespace facet {

namespace {

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
void AdvanceCovariance(const StepJacobian& jacobian,
                       const Vector<6>& variance,
                       double dt,
                       const BiasWalk& walk,
                       Matrix<15, 15>& covariance) {
  Matrix<9, 9> new_xx = covariance.topLeftCorner<9, 9>();
  Matrix<9, 6> new_xb = covariance.topRightCorner<9, 6>();
  const Matrix<6, 9> P_bx = new_xb.transpose();
  const Matrix<6, 6> P_bb = covariance.bottomRightCorner<6, 6>();
  jacobian.Propagate(new_xb);
  new_xb -= jacobian.OfMeasurement(P_bb);
  jacobian.Propagate(new_xx);
  new_xx -= jacobian.OfMeasurement(P_bx);
  new_xx.transposeInPlace();
  jacobian.Propagate(new_xx);
  const Matrix<9, 6> noise_B = jacobian.B() * variance.asDiagonal();
  const Matrix<6, 9> noise = (noise_B - new_xb).transpose();
  new_xx += jacobian.OfMeasurement(noise);
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
  const StepMeasurement measured = MeasureStep(a, b, x.bias, model.gyro_scale);
  const MidpointStep step(x.T_WB.q, measured);
  const Vector3d acceleration = step.acceleration + model.parameters.g_W();

  const ImuParameters& parameters = model.parameters;
  const bool is_hole = dt > model.max_step_s;
  AdvanceCovariance(StepJacobian(measured, step),
                    MeasurementVariance(b, dt, is_hole, parameters),
                    dt,
                    model.walk,
                    state.covariance);
  // Inside a hole the acceleration may also have come early or late.
  const double sigma_p_hole = is_hole ? parameters.accel_in_gap * dt * dt / std::sqrt(12.0) : 0;
  state.covariance.diagonal().segment<3>(3).array() +=
      parameters.integration * parameters.integration * dt + sigma_p_hole * sigma_p_hole;

  x.T_WB.p += x.v_WB * dt + 0.5 * dt * dt * acceleration;
  x.v_WB += dt * acceleration;
  x.T_WB.q = step.q_end;
}

}  // namespace facet
