// SPDX-License-Identifier: BSD-2-Clause
// How a pixel moves with the eight intrinsic parameters of its camera.
#pragma once

#include <optional>

#include "facet/calibration/rig_parameters.h"

namespace facet {

using IntrinsicsVector = Vector<kNumIntrinsics>;

struct ProjectionDerivatives {
  Vector2d px;
  Matrix<2, 3> J_px_p;               ///< by the point in the camera frame
  Matrix<2, kNumIntrinsics> J_px_k;  ///< by fx fy cx cy and the coefficients of distortion
};

/// d pixel / d intrinsic parameters where the point `xy` of the plane z = 1 is seen. Columns of
/// coefficients that the model does not have are zero.
Matrix<2, kNumIntrinsics> IntrinsicsJacobian(const CameraModel& camera, const Vector2d& xy);

/// The same times a change of the parameters, for a point whose pixel is known.
Vector2d ShiftByIntrinsics(const CameraIntrinsics& intrinsics,
                           const Vector2d& xy,
                           const Vector2d& px,
                           const IntrinsicsVector& change);

/// As CameraModel::Project. Columns of coefficients that the model does not have are zero.
std::optional<ProjectionDerivatives> ProjectWithDerivatives(const CameraModel& camera,
                                                            const Vector3d& p_C);

}  // namespace facet
