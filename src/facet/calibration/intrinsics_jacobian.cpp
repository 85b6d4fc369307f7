// SPDX-License-Identifier: BSD-2-Clause
#include "facet/calibration/intrinsics_jacobian.h"

#include "facet/camera/plane_lens.h"
#include "facet/camera/wide_lens.h"

namespace facet {
namespace {

/// d distorted / d coefficients where the direction h is seen.
Matrix<2, 4> CoefficientJacobian(const CameraIntrinsics& k, const Vector3d& h) {
  if (IsWideLens(k.distortion)) return WideLensCoefficientJacobian(k, h);
  return PlaneLensCoefficientJacobian(k, h.head<2>() / h.z());
}

}  // namespace

Vector2d ShiftByIntrinsics(const CameraIntrinsics& k,
                           const Vector3d& h,
                           const Vector2d& px,
                           const IntrinsicsVector& change) {
  const Vector2d moved = CoefficientJacobian(k, h) * change.tail<4>();
  return {(px.x() - k.cx) / k.fx * change(0) + change(2) + k.fx * moved.x(),
          (px.y() - k.cy) / k.fy * change(1) + change(3) + k.fy * moved.y()};
}

Matrix<2, kNumIntrinsics> IntrinsicsJacobian(const CameraIntrinsics& k,
                                             const Vector3d& h,
                                             const Vector2d& px) {
  const Vector2d focal(k.fx, k.fy);
  const Vector2d xy_d = (px - Vector2d(k.cx, k.cy)).cwiseQuotient(focal);
  Matrix<2, kNumIntrinsics> J;
  J << Matrix2d(xy_d.asDiagonal()), Matrix2d::Identity(),
      focal.asDiagonal() * CoefficientJacobian(k, h);
  return J;
}

std::optional<ProjectionDerivatives> ProjectWithDerivatives(const CameraModel& camera,
                                                            const Vector3d& p_C) {
  ProjectionDerivatives d;
  const std::optional<Vector2d> px = camera.Project(p_C, &d.J_px_p);
  if (!px) return std::nullopt;
  d.px = *px;
  d.J_px_k = IntrinsicsJacobian(camera.intrinsics(), p_C, *px);
  return d;
}

}  // namespace facet
