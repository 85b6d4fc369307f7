// SPDX-License-Identifier: BSD-2-Clause
#include "facet/calibration/intrinsics_jacobian.h"

#include <cmath>

#include "facet/camera/lens_models.h"

namespace facet {
namespace {

/// d distorted / d coefficients at a point of the plane z = 1.
Matrix<2, 4> CoefficientJacobian(const CameraIntrinsics& k, const Vector2d& xy) {
  if (k.distortion == DistortionModel::kRadialTangential) return RadialTangentialColumns(xy);
  if (k.distortion != DistortionModel::kEquidistant) return LensCoefficientJacobian(k, xy);
  Matrix<2, 4> J = Matrix<2, 4>::Zero();
  const double r2 = xy.squaredNorm();
  if (r2 > 0) {
    const double theta = std::atan(std::sqrt(r2)), theta2 = theta * theta;
    double power = theta / std::sqrt(r2);
    for (int i = 0; i < 4; ++i) {
      power *= theta2;
      J.col(i) = power * xy;
    }
  }
  return J;
}

/// Where the lens puts a point of the plane z = 1, on that plane.
Vector2d Distort(const CameraIntrinsics& k, const Vector2d& xy) {
  const double x = xy.x(), y = xy.y(), r2 = xy.squaredNorm();
  const auto& c = k.coefficients;
  if (k.distortion == DistortionModel::kRadialTangential) {
    const double radial = 1 + r2 * (c[0] + r2 * c[1]);
    return {x * radial + 2 * c[2] * x * y + c[3] * (r2 + 2 * x * x),
            y * radial + c[2] * (r2 + 2 * y * y) + 2 * c[3] * x * y};
  }
  if (k.distortion == DistortionModel::kEquidistant && r2 > 0) {
    const double r = std::sqrt(r2), theta = std::atan(r), t2 = theta * theta;
    return xy * (theta / r * (1 + t2 * (c[0] + t2 * (c[1] + t2 * (c[2] + t2 * c[3])))));
  }
  return DistortThroughLens(k, xy, nullptr);  // of an equidistant lens the axis alone
}

}  // namespace

Matrix<2, kNumIntrinsics> IntrinsicsJacobian(const CameraModel& camera, const Vector2d& xy) {
  const CameraIntrinsics& k = camera.intrinsics();
  const Vector2d distorted = Distort(k, xy);
  const Matrix<2, 4> J = CoefficientJacobian(k, xy);
  Matrix<2, kNumIntrinsics> out;
  out.row(0) << distorted.x(), 0, 1, 0, k.fx * J.row(0);
  out.row(1) << 0, distorted.y(), 0, 1, k.fy * J.row(1);
  return out;
}

Vector2d ShiftByIntrinsics(const CameraIntrinsics& k,
                           const Vector2d& xy,
                           const Vector2d& px,
                           const IntrinsicsVector& change) {
  const Vector2d moved = CoefficientJacobian(k, xy) * change.tail<4>();
  return {(px.x() - k.cx) / k.fx * change(0) + change(2) + k.fx * moved.x(),
          (px.y() - k.cy) / k.fy * change(1) + change(3) + k.fy * moved.y()};
}

std::optional<ProjectionDerivatives> ProjectWithDerivatives(const CameraModel& camera,
                                                            const Vector3d& p_C) {
  ProjectionDerivatives d;
  const std::optional<Vector2d> px = camera.Project(p_C, &d.J_px_p);
  if (!px) return std::nullopt;
  d.px = *px;
  const CameraIntrinsics& k = camera.intrinsics();
  const Vector2d focal(k.fx, k.fy);
  const Vector2d xy_d = (*px - Vector2d(k.cx, k.cy)).cwiseQuotient(focal);
  d.J_px_k << Matrix2d(xy_d.asDiagonal()), Matrix2d::Identity(),
      focal.asDiagonal() * CoefficientJacobian(k, p_C.head<2>() / p_C.z());
  return d;
}

}  // namespace facet
