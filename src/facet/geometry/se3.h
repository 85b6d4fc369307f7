// SPDX-License-Identifier: BSD-2-Clause
// Rigid transforms. T_AB maps coordinates in B to coordinates in A: p_A = T_AB * p_B.
// Nothing is inline, because nearly every source includes this and would compile Eigen's
// quaternions again.
#pragma once

#include "facet/base/types.h"

namespace facet {

struct SE3 {
  Quaterniond q = Quaterniond::Identity();  ///< Hamilton, unit norm
  Vector3d p = Vector3d::Zero();            ///< origin of B in A [m]

  SE3() = default;
  SE3(const Quaterniond& rotation, const Vector3d& translation) : q(rotation), p(translation) {}

  Matrix3d R() const;
  SE3 Inverse() const;

  /// Rotation perturbed on the right, position additive in A: (theta, p) of docs/conventions.md.
  SE3 Retract(const Vector3d& theta, const Vector3d& dp) const;
};

SE3 operator*(const SE3& a, const SE3& b);
Vector3d operator*(const SE3& T, const Vector3d& x);

}  // namespace facet
