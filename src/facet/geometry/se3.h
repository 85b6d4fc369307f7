// SPDX-License-Identifier: BSD-2-Clause
// Rigid transforms. T_AB maps coordinates in B to coordinates in A: p_A = T_AB * p_B.
#pragma once

#include "facet/base/types.h"
#include "facet/geometry/so3.h"

namespace facet {

struct SE3 {
  Quaterniond q = Quaterniond::Identity();  ///< Hamilton, unit norm
  Vector3d p = Vector3d::Zero();            ///< origin of B in A [m]

  SE3() = default;
  SE3(const Quaterniond& rotation, const Vector3d& translation) : q(rotation), p(translation) {}

  Matrix3d R() const { return q.toRotationMatrix(); }
  SE3 Inverse() const { return {q.conjugate(), -(q.conjugate() * p)}; }

  /// Rotation perturbed on the right, position additive in A: (theta, p) of docs/conventions.md.
  SE3 Retract(const Vector3d& theta, const Vector3d& dp) const {
    return {(q * ExpSO3(theta)).normalized(), p + dp};
  }
};

inline SE3 operator*(const SE3& a, const SE3& b) {
  return {a.q * b.q, a.p + a.q * b.p};
}
inline Vector3d operator*(const SE3& T, const Vector3d& x) {
  return T.q * x + T.p;
}

}  // namespace facet
