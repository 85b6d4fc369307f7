// SPDX-License-Identifier: BSD-2-Clause
// Lenses that move the points of the plane z = 1 and reach less than 90 deg from the axis: none,
// radial-tangential, OpenCV's rational model.
#pragma once

#include "facet/base/types.h"
#include "facet/camera/camera_intrinsics.h"
#include "facet/camera/radial_tangential.h"

namespace facet {

/// r: distance from the axis on the plane z = 1. Tangential terms are left out.
LensRadius RadiusThroughPlaneLens(const CameraIntrinsics& k, double r);

/// From the ideal to the distorted point on the plane z = 1. J: d result / d xy.
Vector2d DistortThroughPlaneLens(const CameraIntrinsics& k, const Vector2d& xy, Matrix2d* J);

/// d distorted / d the first four coefficients, at a point of the plane z = 1. Columns of
/// coefficients that the model does not have are zero.
Matrix<2, 4> PlaneLensCoefficientJacobian(const CameraIntrinsics& k, const Vector2d& xy);

}  // namespace facet
