// SPDX-License-Identifier: BSD-2-Clause
// How a pixel moves with the eight intrinsic parameters of its camera.
#pragma once

#include <optional>

#include "facet/calibration/rig_parameters.h"

namespace facet {

using IntrinsicsVector = Vector<kNumIntrinsics>;

/// d pixel / d fx fy cx cy and the coefficients of distortion at the pixel `px` at which the
/// direction h of the camera is seen. Columns of coefficients that the model does not have are
/// zero.
Matrix<2, kNumIntrinsics> IntrinsicsJacobian(const CameraIntrinsics& intrinsics,
                                             const Vector3d& h,
                                             const Vector2d& px);

struct ProjectionDerivatives {
  Vector2d px;
  Matrix<2, 3> J_px_p;               ///< by the point in the camera frame
  Matrix<2, kNumIntrinsics> J_px_k;  ///< IntrinsicsJacobian
};

/// How far a small change of the parameters moves the pixel `px` at which the direction h of the
/// camera is seen.
Vector2d ShiftByIntrinsics(const CameraIntrinsics& intrinsics,
                           const Vector3d& h,
                           const Vector2d& px,
                           const IntrinsicsVector& change);

/// As CameraModel::Project.
std::optional<ProjectionDerivatives> ProjectWithDerivatives(const CameraModel& camera,
                                                            const Vector3d& p_C);

}  // namespace facet
