// SPDX-License-Identifier: BSD-2-Clause
// A camera as it is believed to be at present: its nominal model, whose parameters are off by a
// little, and what the lens does beside it.
#pragma once

#include <optional>

#include "facet/calibration/intrinsics_jacobian.h"
#include "facet/calibration/smooth_field.h"

namespace facet {

/// Thread-safe (immutable).
class PresentLens {
 public:
  PresentLens() = default;
  /// `change`: of the parameters; counts to first order. What the lens does beside the model is
  /// taken where either the model or the changed model has the point, which differ to second order.
  PresentLens(const CameraModel& nominal,
              const IntrinsicsVector& change,
              const SmoothField& beside_model);

  /// The pixel of a point in the camera frame; empty where CameraModel::Project is.
  std::optional<Vector2d> Project(const Vector3d& p_C) const {
    if (!is_radial_tangential_) return ProjectAsModelled(p_C);
    if (!(p_C.z() > 0)) return std::nullopt;
    const Vector2d xy = p_C.head<2>() / p_C.z();
    const double r2 = xy.squaredNorm();
    if (!(r2 <= max_radius_square_)) return std::nullopt;
    const Vector2d radial = scale_ + r2 * (by_r2_ + r2 * by_r4_);
    const Vector2d square = (2 * xy.array().square() + r2).matrix();
    const Vector2d px = centre_ + xy.cwiseProduct(radial) + xy.x() * xy.y() * by_xy_ +
                        square.cwiseProduct(by_square_);
    return Vector2d(px + beside_model_.At(px));
  }

  /// How far it moves the pixel `px` at which the nominal camera sees the direction h.
  Vector2d Shift(const Vector3d& h, const Vector2d& px) const {
    return ShiftByIntrinsics(nominal_.intrinsics(), h, px, change_) + beside_model_.At(px);
  }

 private:
  std::optional<Vector2d> ProjectAsModelled(const Vector3d& p_C) const;

  CameraModel nominal_;
  IntrinsicsVector change_ = IntrinsicsVector::Zero();
  SmoothField beside_model_;

  // With these the most common lens is one polynomial for each axis: every residual goes through
  // it.
  bool is_radial_tangential_ = false;
  double max_radius_square_ = 0;
  Vector2d centre_, scale_, by_r2_, by_r4_, by_xy_, by_square_;  ///< [px]
};

}  // namespace facet
