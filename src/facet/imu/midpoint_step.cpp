// SPDX-License-Identifier: BSD-2-Clause
#include "facet/imu/midpoint_step.h"

#include "facet/geometry/so3.h"

namespace facet {

StepMeasurement MeasureStep(const ImuSample& a,
                            const ImuSample& b,
                            const ImuBias& bias,
                            const Vector3d& gyro_scale) {
  const Vector3d gyro = 0.5 * (a.gyro + b.gyro);
  return {ToSeconds(b.t - a.t),
          gyro - gyro_scale.cwiseProduct(gyro) - bias.b_g,
          a.accel - bias.b_a,
          b.accel - bias.b_a};
}

MidpointStep::MidpointStep(const Quaterniond& q0, const StepMeasurement& measured)
    : q_step(ExpSO3(measured.w * measured.dt)),
      q_end((q0 * q_step).normalized()),
      R0(q0.toRotationMatrix()),
      R1(q_end.toRotationMatrix()),
      acceleration(0.5 * (R0 * measured.a0 + R1 * measured.a1)) {}

StepJacobian::StepJacobian(const StepMeasurement& measured, const MidpointStep& step)
    : half_dt_(0.5 * measured.dt),
      theta_theta_(step.q_step.toRotationMatrix().transpose()),
      theta_w_(RightJacobianSO3(measured.w * measured.dt) * measured.dt) {
  const Matrix3d half_R1_hat = 0.5 * step.R1 * Hat(measured.a1);
  v_theta_ = measured.dt * (-0.5 * step.R0 * Hat(measured.a0) - half_R1_hat * theta_theta_);
  v_w_ = -measured.dt * half_R1_hat * theta_w_;
  v_a_ = half_dt_ * (step.R0 + step.R1);
}

Matrix<9, 6> StepJacobian::B() const {
  Matrix<9, 6> B;
  B << theta_w_, Matrix3d::Zero(), half_dt_ * v_w_, half_dt_ * v_a_, v_w_, v_a_;
  return B;
}

}  // namespace facet
