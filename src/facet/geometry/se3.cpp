// SPDX-License-Identifier: BSD-2-Clause
#include "facet/geometry/se3.h"

#include "facet/geometry/so3.h"

namespace facet {

Matrix3d SE3::R() const {
  return q.toRotationMatrix();
}

SE3 SE3::Inverse() const {
  return {q.conjugate(), -(q.conjugate() * p)};
}

SE3 SE3::Retract(const Vector3d& theta, const Vector3d& dp) const {
  return {(q * ExpSO3(theta)).normalized(), p + dp};
}

SE3 operator*(const SE3& a, const SE3& b) {
  return {a.q * b.q, a.p + a.q * b.p};
}

Vector3d operator*(const SE3& T, const Vector3d& x) {
  return T.q * x + T.p;
}

}  // namespace facet
