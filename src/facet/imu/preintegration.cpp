// SPDX-License-Identifier: BSD-2-Clause
#include "facet/imu/preintegration.h"

#include "facet/base/check.h"
#include "facet/geometry/so3.h"

namespace facet {

namespace {

void CheckThatTheyMeet(const std::vector<ImuSample>& before, const ImuSample& next) {
  FACET_CHECK(before.empty() || next.t == before.back().t)
      << "the interval ends at " << before.back().t.ns << " but the samples begin at " << next.t.ns;
}

}  // namespace

void ImuPreintegration::Integrate(std::span<const ImuSample> samples, const StepNoise& noise) {
  if (samples.empty()) return;
  CheckThatTheyMeet(samples_, samples.front());
  samples_.reserve(samples_.size() + samples.size());
  step_noise_.reserve(step_noise_.size() + samples.size());
  for (const ImuSample& sample : samples)
    Add(sample, noise);
}

void ImuPreintegration::Append(const ImuPreintegration& next) {
  if (next.samples_.empty()) return;
  CheckThatTheyMeet(samples_, next.samples_.front());
  samples_.reserve(samples_.size() + next.samples_.size());
  step_noise_.reserve(step_noise_.size() + next.samples_.size());
  for (std::size_t i = 0; i < next.samples_.size(); ++i)
    Add(next.samples_[i], next.step_noise_[i]);
}

void ImuPreintegration::Reintegrate(const ImuBias& bias, const Vector3d& gyro_scale) {
  ImuPreintegration fresh(bias, parameters_, gyro_scale);
  fresh.Append(*this);
  *this = std::move(fresh);
}

// Where two intervals meet, both have a sample with the stamp of the seam, possibly one of them
// held: the first one counts.
void ImuPreintegration::Add(const ImuSample& sample, const StepNoise& noise) {
  if (!samples_.empty()) {
    FACET_CHECK(sample.t >= samples_.back().t)
        << "sample at " << sample.t.ns << " after one at " << samples_.back().t.ns;
    if (sample.t == samples_.back().t) return;
    Step(samples_.back(), sample, noise);
  }
  samples_.push_back(sample);
  step_noise_.push_back(noise);
}

// Midpoint rule: mean rate, and the mean of the accelerations at both ends turned into the first
// body frame. Its linearisation in (theta, p, v), in the noise of the mean measurements and in the
// biases is in docs/math.md, section 2.
void ImuPreintegration::Step(const ImuSample& a, const ImuSample& b, const StepNoise& step_noise) {
  const double dt = ToSeconds(b.t - a.t);
  const Vector3d gyro = 0.5 * (a.gyro + b.gyro);
  const Vector3d w = gyro - gyro_scale_.cwiseProduct(gyro) - bias_.b_g;
  const Vector3d a0 = a.accel - bias_.b_a;
  const Vector3d a1 = b.accel - bias_.b_a;
  const Quaterniond q_step = ExpSO3(w * dt);
  const Quaterniond q_end = (dR_ * q_step).normalized();
  const Matrix3d R_step_T = q_step.toRotationMatrix().transpose();
  const Matrix3d R0 = dR_.toRotationMatrix();
  const Matrix3d R1 = q_end.toRotationMatrix();
  const Vector3d acceleration = 0.5 * (R0 * a0 + R1 * a1);

  // d acceleration / d theta, / d gyro, / d accel.
  const Matrix3d J_theta_w = RightJacobianSO3(w * dt) * dt;
  const Matrix3d half_R1_hat = 0.5 * R1 * Hat(a1);
  const Matrix3d J_acc_theta = -0.5 * R0 * Hat(a0) - half_R1_hat * R_step_T;
  const Matrix3d J_acc_w = -half_R1_hat * J_theta_w;
  const Matrix3d J_acc_a = 0.5 * (R0 + R1);

  Matrix<9, 9> A = Matrix<9, 9>::Identity();
  A.block<3, 3>(0, 0) = R_step_T;
  A.block<3, 3>(3, 0) = 0.5 * dt * dt * J_acc_theta;
  A.block<3, 3>(3, 6) = dt * Matrix3d::Identity();
  A.block<3, 3>(6, 0) = dt * J_acc_theta;

  Matrix<9, 6> B;
  B.block<3, 3>(0, 0) = J_theta_w;
  B.block<3, 3>(0, 3).setZero();
  B.block<3, 3>(3, 0) = 0.5 * dt * dt * J_acc_w;
  B.block<3, 3>(3, 3) = 0.5 * dt * dt * J_acc_a;
  B.block<3, 3>(6, 0) = dt * J_acc_w;
  B.block<3, 3>(6, 3) = dt * J_acc_a;

  // Variance of the mean measurement over the step. Neighbouring steps share a sample, yet count as
  // independent: summed over a chain of intervals that gives every sample its full weight.
  const bool is_gap = dt > step_noise.max_step_s;
  const double gap_w = is_gap ? parameters_.gyro_in_gap : 0.0;
  const double gap_a = is_gap ? parameters_.accel_in_gap : 0.0;
  const double gyro_noise = parameters_.gyro * step_noise.scale;
  const double accel_noise = parameters_.accel * step_noise.scale;
  const double integration = parameters_.integration * step_noise.scale;
  Vector<6> variance;
  variance.head<3>().setConstant(gyro_noise * gyro_noise / dt + gap_w * gap_w);
  variance.tail<3>().setConstant(accel_noise * accel_noise / dt + gap_a * gap_a);
  variance.head<3>() += b.gyro_doubt.cwiseAbs2();
  variance.tail<3>() += b.accel_doubt.cwiseAbs2();

  covariance_ = A * covariance_ * A.transpose() + B * variance.asDiagonal() * B.transpose();
  // Inside a hole the acceleration may also have come early or late: (p, v) are not tied together.
  const double sigma_p_gap = gap_a * dt * dt / std::sqrt(12.0);
  covariance_.block<3, 3>(3, 3).diagonal().array() +=
      integration * integration * dt + sigma_p_gap * sigma_p_gap;
  J_bias_ = A * J_bias_ - B;
  J_scale_ = A * J_scale_ - B.leftCols<3>() * gyro.asDiagonal();

  dp_ += dv_ * dt + 0.5 * dt * dt * acceleration;
  dv_ += dt * acceleration;
  dR_ = q_end;
  dt_s_ += dt;
}

NavState ImuPreintegration::Predict(const NavState& start) const {
  Vector<6> db;
  db << start.bias.b_g - bias_.b_g, start.bias.b_a - bias_.b_a;
  const Vector<9> correction = J_bias_ * db;
  const Vector3d g_W = this->g_W();

  NavState end = start;
  if (!samples_.empty()) end.t = start.t + (samples_.back().t - samples_.front().t);
  const Quaterniond& q_WB = start.T_WB.q;
  end.T_WB.q = (q_WB * dR_ * ExpSO3(correction.head<3>())).normalized();
  end.T_WB.p +=
      start.v_WB * dt_s_ + 0.5 * dt_s_ * dt_s_ * g_W + q_WB * (dp_ + correction.segment<3>(3));
  end.v_WB += g_W * dt_s_ + q_WB * (dv_ + correction.tail<3>());
  return end;
}

}  // namespace facet
