// SPDX-License-Identifier: BSD-2-Clause
#include "facet/geometry/so3.h"

#include <cmath>

namespace facet {

namespace {
// Below this angle the closed forms lose digits and the series is exact to double precision.
constexpr double kSmallAngle = 1e-4;
}  // namespace

Matrix3d Hat(const Vector3d& a) {
  Matrix3d m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

Quaterniond ExpSO3(const Vector3d& theta) {
  const double angle = theta.norm();
  const double half = 0.5 * angle;
  const double s = angle < kSmallAngle ? 0.5 - angle * angle / 48.0 : std::sin(half) / angle;
  Quaterniond q(std::cos(half), s * theta.x(), s * theta.y(), s * theta.z());
  q.normalize();
  return q;
}

Vector3d LogSO3(const Quaterniond& q) {
  const double sign = q.w() < 0 ? -1.0 : 1.0;
  const Vector3d v = sign * q.vec();
  const double w = sign * q.w();
  const double n = v.norm();
  if (n < kSmallAngle) return v * (2.0 / w) * (1.0 - n * n / (3.0 * w * w));
  return v * (2.0 * std::atan2(n, w) / n);
}

Matrix3d RightJacobianSO3(const Vector3d& theta) {
  const double t2 = theta.squaredNorm();
  const double t = std::sqrt(t2);
  const Matrix3d h = Hat(theta);
  if (t < kSmallAngle) return Matrix3d::Identity() - 0.5 * h + h * h / 6.0;
  return Matrix3d::Identity() - (1 - std::cos(t)) / t2 * h + (t - std::sin(t)) / (t2 * t) * h * h;
}

Matrix3d RightJacobianInverseSO3(const Vector3d& theta) {
  const double t2 = theta.squaredNorm();
  const double t = std::sqrt(t2);
  const Matrix3d h = Hat(theta);
  if (t < kSmallAngle) return Matrix3d::Identity() + 0.5 * h + h * h / 12.0;
  // (1 + cos t) / (2 t sin t) written with the half angle: no cancellation near pi.
  const double half = 0.5 * t;
  const double c = 1.0 / t2 - std::cos(half) / (2.0 * t * std::sin(half));
  return Matrix3d::Identity() + 0.5 * h + c * h * h;
}

// As Quaterniond::FromTwoVectors, without the singular value decomposition that it has for opposite
// directions and that takes longer to compile than the rest of this file.
Quaterniond RotationBetween(const Vector3d& from, const Vector3d& to) {
  const Vector3d a = from.normalized(), b = to.normalized();
  const double cosine = b.dot(a);
  Quaterniond q;
  if (cosine < -1 + 1e-12) {
    q.w() = 0;
    q.vec() = TangentBasis(a).col(0);  // any axis across
    return q;
  }
  const double s = std::sqrt((1 + cosine) * 2);
  q.w() = s * 0.5;
  q.vec() = a.cross(b) * (1 / s);
  return q.normalized();
}

Matrix<3, 2> TangentBasis(const Vector3d& n) {
  int smallest = 0;
  n.cwiseAbs().minCoeff(&smallest);
  Matrix<3, 2> basis;
  basis.col(0) = n.cross(Vector3d::Unit(smallest)).normalized();
  basis.col(1) = n.cross(basis.col(0));
  return basis;
}

}  // namespace facet
