// SPDX-License-Identifier: BSD-2-Clause
#include "facet/calibration/triangulation_jacobian.h"

#include <Eigen/LU>

#include "facet/calibration/intrinsics_jacobian.h"
#include "facet/geometry/so3.h"

namespace facet {

std::optional<Matrix<3, kNumRigParameters>> TriangulationJacobian(const StereoRig& rig,
                                                                  const Vector3d& p_C0) {
  constexpr double kLeastShift = 1e-9;  // of the right ray for a metre of depth
  const SE3 T_C1C0 = rig.T_C1C0();
  const Matrix3d R = T_C1C0.R();
  const auto left = ProjectWithDerivatives(rig.cameras[0], p_C0);
  const auto right = ProjectWithDerivatives(rig.cameras[1], T_C1C0 * p_C0);
  if (!left || !right) return std::nullopt;
  const double z = p_C0.z();

  // The ray of the left pixel turns; the depth stays.
  Matrix<3, kNumRigParameters> J = Matrix<3, kNumRigParameters>::Zero();
  J.topLeftCorner<2, kNumIntrinsics>() = -left->J_px_p.leftCols<2>().inverse() * left->J_px_k;

  // Where the right camera would then see it, and the depth that brings it back along the line on
  // which depth moves it, on the plane z = 1.
  const Matrix2d J_xy_px = right->J_px_p.leftCols<2>().inverse() / (T_C1C0 * p_C0).z();
  Matrix<2, kNumRigParameters> moved_px = right->J_px_p * R * J;
  moved_px.middleCols<kNumIntrinsics>(kNumIntrinsics) += right->J_px_k;
  moved_px.middleCols<3>(kStereoRotation) -= right->J_px_p * R * Hat(p_C0);
  moved_px.middleCols<3>(kStereoTranslation) += right->J_px_p;
  const Vector3d ray = p_C0 / z;
  const Vector2d per_depth = J_xy_px * (right->J_px_p * (R * ray));
  if (!(per_depth.norm() > kLeastShift)) return std::nullopt;
  J -= ray * (per_depth.transpose() * J_xy_px * moved_px) / per_depth.squaredNorm();
  return J;
}

}  // namespace facet
