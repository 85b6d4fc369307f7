// SPDX-License-Identifier: BSD-2-Clause
#include "facet/robot/motion_covariance.h"

#include <Eigen/Dense>

namespace facet {
namespace robot {

namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using RowMajor6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
using RowMajor15 = Eigen::Matrix<double, 15, 15, Eigen::RowMajor>;
using Jacobian = Eigen::Matrix<double, 6, 15>;

constexpr int kTheta = 0, kP = 3, kV = 6, kGyroBias = 9;

Vector3d Vector(const api::Vec3& v) {
  return {v[0], v[1], v[2]};
}

api::Vec3 Plain(const Vector3d& v) {
  return {{v.x(), v.y(), v.z()}};
}

Quaterniond Rotation(const api::Pose& T) {
  return Quaterniond(T.q[0], T.q[1], T.q[2], T.q[3]).normalized();
}

Matrix3d Hat(const Vector3d& v) {
  Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

RowMajor6 Propagate(const Jacobian& J, const StateCovariance& covariance) {
  const Eigen::Map<const RowMajor15> state(covariance.data());
  const RowMajor6 result = J * state * J.transpose();
  return 0.5 * (result + result.transpose());
}

Covariance6 Plain(const RowMajor6& matrix) {
  Covariance6 plain;
  Eigen::Map<RowMajor6>(plain.data()) = matrix;
  return plain;
}

api::Pose Plain(const Quaterniond& q, const Vector3d& p) {
  return {Plain(p), {{q.w(), q.x(), q.y(), q.z()}}};
}

}  // namespace

api::Pose Compose(const api::Pose& T_WA, const api::Pose& T_AB) {
  const Quaterniond R_WA = Rotation(T_WA);
  return Plain((R_WA * Rotation(T_AB)).normalized(), Vector(T_WA.p) + R_WA * Vector(T_AB.p));
}

api::Pose Inverse(const api::Pose& T_AB) {
  const Quaterniond R_BA = Rotation(T_AB).conjugate();
  return Plain(R_BA, -(R_BA * Vector(T_AB.p)));
}

api::Vec3 InFrame(const api::Pose& T_WA, const api::Vec3& v_W) {
  return Plain(Vector3d(Rotation(T_WA).conjugate() * Vector(v_W)));
}

// R Exp(theta) = Exp(R theta) R: theta on the right is R theta about the fixed axes. What turns B
// moves a point at p_BF by R (theta x p_BF).
Covariance6 PoseCovariance(const api::Pose& T_WB,
                           const api::Pose& T_BF,
                           const StateCovariance& covariance) {
  const Matrix3d R_WB = Rotation(T_WB).toRotationMatrix();
  Jacobian J = Jacobian::Zero();
  J.block<3, 3>(0, kTheta) = -R_WB * Hat(Vector(T_BF.p));
  J.block<3, 3>(0, kP).setIdentity();
  J.block<3, 3>(3, kTheta) = R_WB;
  return Plain(Propagate(J, covariance));
}

// v_F = R^T v_W, and (R Exp(theta))^T v_W = v_F - theta x v_F = v_F + v_F x theta.
Covariance6 TwistCovariance(const api::Motion& motion,
                            const api::Pose& T_BF,
                            double gyro_variance) {
  const Matrix3d R_FW = Rotation(motion.T_WF).conjugate().toRotationMatrix();
  Jacobian J = Jacobian::Zero();
  J.block<3, 3>(0, kTheta) = Hat(R_FW * Vector(motion.v_WF));
  J.block<3, 3>(0, kV) = R_FW;
  J.block<3, 3>(3, kGyroBias) = -Rotation(T_BF).conjugate().toRotationMatrix();
  RowMajor6 twist = Propagate(J, motion.covariance);
  twist.diagonal().tail<3>().array() += gyro_variance;
  return Plain(twist);
}

}  // namespace robot
}  // namespace facet
