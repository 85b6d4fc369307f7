// SPDX-License-Identifier: BSD-2-Clause
// Lenses that most calibrations do not need: OpenCV's rational model, and the models of wide lenses
// (field of view, double sphere, extended unified, unified). All of them say where a point of the
// plane z = 1 is seen on that plane, so they reach as far as a pinhole does, that is below 90 deg
// from the axis. None at all is one of them; the two common models are in radial_tangential.h and
// camera_model.cpp.
#pragma once

#include <string>

#include "facet/base/types.h"
#include "facet/camera/camera_intrinsics.h"
#include "facet/camera/radial_tangential.h"

namespace facet {

/// r: distance from the axis on the plane z = 1. Tangential terms are left out.
LensRadius RadiusThroughLens(const CameraIntrinsics& k, double r);

/// Whether the lens is described best by the angle from the axis, because the radius on the plane
/// z = 1 grows without bound within its view.
bool IsWideLens(DistortionModel model);

/// From the ideal to the distorted point on the plane z = 1. J: d result / d xy.
Vector2d DistortThroughLens(const CameraIntrinsics& k, const Vector2d& xy, Matrix2d* J);

/// d distorted / d the first four coefficients, at a point of the plane z = 1. Columns of
/// coefficients that the model does not have are zero.
Matrix<2, 4> LensCoefficientJacobian(const CameraIntrinsics& k, const Vector2d& xy);

/// Coefficients that no lens has, in words; empty: nothing is wrong.
std::string WhatIsWrongWithLens(const CameraIntrinsics& k);

}  // namespace facet
