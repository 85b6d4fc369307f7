// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/warp_prediction.h"

#include <cmath>

namespace facet {

namespace {

// Of a patch at unit distance: how far its points are apart, per pixel. Its surface is not known.
// Across the ray is best where surfaces lie in all directions, parallel to the image where the
// camera looks at one straight; half-way between the two costs least where the other one is right.
Matrix<3, 2> AlongPatch(const PixelBearing& ray) {
  const Vector3d normal = ray.bearing + Vector3d::UnitZ();
  const Matrix<3, 2> across = AcrossRay(ray.J_px_bearing);
  return across - ray.bearing * (normal.transpose() * across) / normal.dot(ray.bearing);
}

}  // namespace

std::optional<PatchWarp> PredictWarp(const PixelBearing& ray,
                                     double rho,
                                     const SE3& T_to_from,
                                     const CameraModel& camera) {
  const Matrix3d R = T_to_from.R();
  const Vector3d p = R * ray.bearing + rho * T_to_from.p;
  Matrix<2, 3> J_px_p;
  const std::optional<Vector2d> px = camera.Project(p, &J_px_p);
  if (!px) return std::nullopt;
  const Matrix2d A = J_px_p * R * AlongPatch(ray);
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
