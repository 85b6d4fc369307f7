// SPDX-License-Identifier: BSD-2-Clause
// Lenses that are described by directions and reach beyond 90 deg from the axis: equidistant
// (Kannala and Brandt), field of view, double sphere, extended unified, unified. Each puts the
// direction (x, y, z) at scale * (x, y) of a plane with unit focal length.
#pragma once

#include <optional>
#include <string>

#include "facet/base/types.h"
#include "facet/camera/camera_intrinsics.h"
#include "facet/camera/radial_tangential.h"

namespace facet {

inline bool IsWideLens(DistortionModel model) {
  return model == DistortionModel::kEquidistant || model == DistortionModel::kFieldOfView ||
         model == DistortionModel::kDoubleSphere || model == DistortionModel::kExtendedUnified ||
         model == DistortionModel::kUnified;
}

/// Where the lens puts the direction p (any length); empty where it images nothing. J: d result /
/// d p.
std::optional<Vector2d> ProjectThroughWideLens(const CameraIntrinsics& k,
                                               const Vector3d& p,
                                               Matrix<2, 3>* J);

/// How far from the axis it puts a ray that is so many radians off it, and the derivative of that.
/// Tangential terms are left out.
LensRadius RadiusOfAngle(const CameraIntrinsics& k, double angle);

/// d result of ProjectThroughWideLens / d the first four coefficients. Columns of coefficients that
/// the model does not have are zero.
Matrix<2, 4> WideLensCoefficientJacobian(const CameraIntrinsics& k, const Vector3d& p);

/// Coefficients that no lens has, in words; empty: nothing is wrong.
std::string WhatIsWrongWithWideLens(const CameraIntrinsics& k);

}  // namespace facet
