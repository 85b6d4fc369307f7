// SPDX-License-Identifier: BSD-2-Clause
#include "facet/calibration/triangulation_jacobian.h"

#include <Eigen/LU>

#include "facet/calibration/intrinsics_jacobian.h"
#include "facet/geometry/so3.h"

namespace facet {

std::optional<Matrix<3, kNumRigParameters>> TriangulationJacobian(const StereoRig& rig,
                                                                  const Vector3d& p_C0) {
  constexpr double kLeastShift_px = 1e-6;  // of the right pixel for a metre of distance
  const SE3 T_C1C0 = rig.T_C1C0();
  const Matrix3d R = T_C1C0.R();
  const auto left = ProjectWithDerivatives(rig.cameras[0], p_C0);
  const auto right = ProjectWithDerivatives(rig.cameras[1], T_C1C0 * p_C0);
  if (!left || !right) return std::nullopt;

  // The ray of the left pixel turns; the distance stays.
  Matrix<3, kNumRigParameters> J = Matrix<3, kNumRigParameters>::Zero();
  J.leftCols<kNumIntrinsics>() = -AcrossRay(left->J_px_p) * left->J_px_k;

  // Where the right camera would then see it, and the distance that brings it back along the line
  // on which distance moves it.
  Matrix<2, kNumRigParameters> moved_px = right->J_px_p * R * J;
  moved_px.middleCols<kNumIntrinsics>(kNumIntrinsics) += right->J_px_k;
  moved_px.middleCols<3>(kStereoRotation) -= right->J_px_p * R * Hat(p_C0);
  moved_px.middleCols<3>(kStereoTranslation) += right->J_px_p;
  const Vector3d ray = p_C0.normalized();
  const Vector2d per_metre_px = right->J_px_p * (R * ray);
  if (!(per_metre_px.norm() > kLeastShift_px)) return std::nullopt;
  J -= ray * (per_metre_px.transpose() * moved_px) / per_metre_px.squaredNorm();
  return J;
}

}  // namespace facet
