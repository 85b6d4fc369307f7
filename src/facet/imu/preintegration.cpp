// SPDX-License-Identifier: BSD-2-Clause
#include "facet/imu/preintegration.h"

#include "facet/base/check.h"

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

// Its linearisation in (theta, p, v), in the noise of the mean measurements and in the biases is in
// docs/math.md, section 2.
void ImuPreintegration::Step(const ImuSample& a, const ImuSample& b, const StepNoise& step_noise) {
  const StepMeasurement measured = MeasureStep(a, b, bias_, gyro_scale_);
  const MidpointStep step(motion_.dR, measured);
  const StepJacobian jacobian(measured, step);
  const double dt = measured.dt;

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

  const Matrix<9, 6> B = jacobian.B();
  jacobian.Propagate(covariance_);
  covariance_.transposeInPlace();
  jacobian.Propagate(covariance_);
  const Matrix<6, 9> noise = variance.asDiagonal() * B.transpose();
  covariance_ += jacobian.OfMeasurement(noise);
  // Inside a hole the acceleration may also have come early or late: (p, v) are not tied together.
  const double sigma_p_gap = gap_a * dt * dt / std::sqrt(12.0);
  covariance_.block<3, 3>(3, 3).diagonal().array() +=
      integration * integration * dt + sigma_p_gap * sigma_p_gap;
  jacobian.Propagate(J_bias_);
  J_bias_ -= B;
  const Vector3d gyro = 0.5 * (a.gyro + b.gyro);
  jacobian.Propagate(J_scale_);
  J_scale_ -= B.leftCols<3>() * gyro.asDiagonal();

  motion_.Add(dt, step);
}

NavState ImuPreintegration::Predict(const NavState& start) const {
  Vector<6> db;
  db << start.bias.b_g - bias_.b_g, start.bias.b_a - bias_.b_a;
  NavState end = motion_.From(start, g_W(), J_bias_ * db);
  if (!samples_.empty()) end.t = start.t + (samples_.back().t - samples_.front().t);
  return end;
}

}  // namespace facet
