// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/factors/start_prior_factor.h"

#include "facet/base/check.h"
#include "facet/geometry/so3.h"

namespace facet {

static_assert(Factor<StartPriorFactor>);

namespace {

int IndexOfFirst(const SlidingWindow& window) {
  const int index = window.IndexOf(window.start_prior->frame);
  FACET_CHECK(index >= 0 && window.frames[index].has_motion) << "start prior without its frame";
  return index;
}

}  // namespace

StartPriorFactor::StartPriorFactor(const SlidingWindow& window)
    : prior_(window.start_prior.value()),
      frame_(IndexOfFirst(window)),
      x_(window.frames[frame_].x) {}

Vector3d StartPriorFactor::RotationInWorld() const {
  return LogSO3(x_.T_WB.q * prior_.T_WB.q.conjugate());
}

Vector<13> StartPriorFactor::Error() const {
  Vector<13> r;
  r.head<3>() = (x_.T_WB.p - prior_.T_WB.p) / prior_.sigma_position;
  r(3) = RotationInWorld().z() / prior_.sigma_yaw;
  r.segment<3>(4) = x_.v_WB / prior_.sigma_velocity;
  r.segment<3>(7) = x_.bias.b_g / prior_.sigma_gyro_bias;
  r.segment<3>(10) = x_.bias.b_a / prior_.sigma_accel_bias;
  return r;
}

double StartPriorFactor::AddTo(NormalEquations& equations) const {
  const Vector<13> r = Error();
  Matrix<13, 15> J = Matrix<13, 15>::Zero();
  J.block<3, 3>(0, 3) = Matrix3d::Identity() / prior_.sigma_position;
  // Log(R Exp(theta) R0^T) ~ Log(R R0^T) + Jl^-1 R theta, and Jl^-1(w) = Jr^-1(-w).
  J.block<1, 3>(3, 0) =
      (RightJacobianInverseSO3(-RotationInWorld()) * x_.T_WB.R()).row(2) / prior_.sigma_yaw;
  J.block<3, 3>(4, 6) = Matrix3d::Identity() / prior_.sigma_velocity;
  J.block<3, 3>(7, 9) = Matrix3d::Identity() / prior_.sigma_gyro_bias;
  J.block<3, 3>(10, 12) = Matrix3d::Identity() / prior_.sigma_accel_bias;
  equations.AddRows({Variable::Pose(frame_), Variable::Motion(frame_)}, J, r);
  return 0.5 * r.squaredNorm();
}

}  // namespace facet
