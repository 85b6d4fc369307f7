// SPDX-License-Identifier: BSD-2-Clause
// Rotations: exponential, logarithm and right Jacobians (docs/math.md, section 1).
// A rotation R is perturbed on the right: R <- R Exp(theta).
#pragma once

#include "facet/base/types.h"

namespace facet {

/// Cross-product matrix: Hat(a) * b == a.cross(b).
Matrix3d Hat(const Vector3d& a);

/// Rotation by |theta| rad about theta.
Quaterniond ExpSO3(const Vector3d& theta);

/// Inverse of ExpSO3, |theta| <= pi.
Vector3d LogSO3(const Quaterniond& q);

/// Jr(theta): Exp(theta + d) ~ Exp(theta) Exp(Jr(theta) d).
Matrix3d RightJacobianSO3(const Vector3d& theta);

/// Jr^-1(theta): Log(Exp(theta) Exp(d)) ~ theta + Jr^-1(theta) d. Valid for |theta| < 2 pi.
Matrix3d RightJacobianInverseSO3(const Vector3d& theta);

/// Smallest rotation that takes the direction of `from` to the direction of `to`.
Quaterniond RotationBetween(const Vector3d& from, const Vector3d& to);

/// Two unit vectors that complete the unit vector n to an orthogonal right-handed frame.
Matrix<3, 2> TangentBasis(const Vector3d& n);

}  // namespace facet
