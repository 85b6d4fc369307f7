// SPDX-License-Identifier: BSD-2-Clause
#include "facet/calibration/present_lens.h"

#include <cmath>

namespace facet {

PresentLens::PresentLens(const CameraModel& nominal,
                         const IntrinsicsVector& change,
                         const SmoothField& beside_model)
    : nominal_(nominal), change_(change), beside_model_(beside_model) {
  const CameraIntrinsics& k = nominal.intrinsics();
  is_radial_tangential_ = k.distortion == DistortionModel::kRadialTangential;
  if (!is_radial_tangential_) return;
  const double max_radius = std::tan(nominal.max_angle());
  max_radius_square_ = max_radius * max_radius;
  const Vector2d focal(k.fx, k.fy);
  // Focal lengths times a coefficient, with the changes of both to first order.
  const auto changed = [&](int coefficient) {
    const double c = k.coefficients[static_cast<std::size_t>(coefficient)];
    return Vector2d(c * (focal + change.head<2>()) + change(4 + coefficient) * focal);
  };
  centre_ = Vector2d(k.cx, k.cy) + change.segment<2>(2);
  scale_ = focal + change.head<2>();
  by_r2_ = changed(0);
  by_r4_ = changed(1);
  const Vector2d by_p1 = changed(2), by_p2 = changed(3);
  by_xy_ = 2 * Vector2d(by_p1.x(), by_p2.y());
  by_square_ = Vector2d(by_p2.x(), by_p1.y());
}

std::optional<Vector2d> PresentLens::ProjectAsModelled(const Vector3d& p_C) const {
  const std::optional<Vector2d> px = nominal_.Project(p_C);
  if (!px) return std::nullopt;
  return Vector2d(*px + Shift(p_C, *px));
}

}  // namespace facet
