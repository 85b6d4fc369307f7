// SPDX-License-Identifier: BSD-2-Clause
#include "facet/plausibility/force_integral.h"

namespace facet {
namespace {

void Advance(const Matrix3d& acceleration, double dt_s, ForceIntegral::ByAxis& sum) {
  sum.displacement += dt_s * sum.velocity + 0.5 * dt_s * dt_s * acceleration;
  sum.velocity += dt_s * acceleration;
}

}  // namespace

void ForceIntegral::Integrate(std::span<const ImuSample> samples) {
  for (std::size_t i = 1; i < samples.size(); ++i)
    Step(samples[i - 1], samples[i]);
}

// As the preintegration does it (docs/math.md, section 2): mean rate, mean of the accelerations at
// both ends.
void ForceIntegral::Step(const ImuSample& a, const ImuSample& b) {
  const double dt_s = ToSeconds(b.t - a.t);
  const Vector3d reading = 0.5 * (a.gyro + b.gyro);
  const Vector3d w_B = reading - gyro_scale_.cwiseProduct(reading) - b_g_;
  const Matrix3d R_end = R_ * ExpSO3(w_B * dt_s).toRotationMatrix();
  Advance(0.5 * (R_ * a.accel.asDiagonal().toDenseMatrix() +
                 R_end * b.accel.asDiagonal().toDenseMatrix()),
          dt_s,
          measured_);
  Advance(0.5 * (R_ + R_end), dt_s, constant_);
  R_ = R_end;
  dt_s_ += dt_s;
}

}  // namespace facet
