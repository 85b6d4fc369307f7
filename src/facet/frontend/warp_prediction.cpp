// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/warp_prediction.h"

#include <cmath>

namespace facet {

std::optional<PatchWarp> PredictWarp(const UndistortedPoint& ray,
                                     double rho,
                                     const SE3& T_to_from,
                                     const CameraModel& camera) {
  const Matrix3d R = T_to_from.R();
  const Vector3d p = R * Vector3d(ray.xy.x(), ray.xy.y(), 1) + rho * T_to_from.p;
  Matrix<2, 3> J_px_p;
  const std::optional<Vector2d> px = camera.Project(p, &J_px_p);
  if (!px) return std::nullopt;
  const Matrix2d A = J_px_p * R.leftCols<2>() * ray.J_xy_px;
  PatchWarp warp;
  warp.a00 = static_cast<float>(A(0, 0));
  warp.a01 = static_cast<float>(A(0, 1));
  warp.a10 = static_cast<float>(A(1, 0));
  warp.a11 = static_cast<float>(A(1, 1));
  warp.x = static_cast<float>(px->x());
  warp.y = static_cast<float>(px->y());
  return warp;
}

PatchWarp ComposeLinear(const PatchWarp& second, const PatchWarp& first) {
  PatchWarp warp = second;
  warp.a00 = second.a00 * first.a00 + second.a01 * first.a10;
  warp.a01 = second.a00 * first.a01 + second.a01 * first.a11;
  warp.a10 = second.a10 * first.a00 + second.a11 * first.a10;
  warp.a11 = second.a10 * first.a01 + second.a11 * first.a11;
  return warp;
}

PatchWarp InverseAt(const PatchWarp& warp, float x, float y) {
  PatchWarp inverse;
  inverse.x = x;
  inverse.y = y;
  const float det = warp.a00 * warp.a11 - warp.a01 * warp.a10;
  if (!(std::abs(det) > 1e-6F)) return inverse;
  inverse.a00 = warp.a11 / det;
  inverse.a01 = -warp.a01 / det;
  inverse.a10 = -warp.a10 / det;
  inverse.a11 = warp.a00 / det;
  return inverse;
}

float Scale(const PatchWarp& warp) {
  return std::sqrt(std::abs(warp.a00 * warp.a11 - warp.a01 * warp.a10));
}

}  // namespace facet
