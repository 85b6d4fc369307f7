// SPDX-License-Identifier: BSD-2-Clause
// Cameras of any resolution with the lenses of DistortionModel. Images are never rectified: points
// are undistorted.
#pragma once

#include <optional>
#include <string>

#include <Eigen/LU>

#include "facet/base/types.h"
#include "facet/camera/camera_intrinsics.h"

namespace facet {

/// [m] What is nearer than this to a camera is beside it or on the lens and counts as not in view.
inline constexpr double kMinDistance_m = 0.05;

/// The direction in which a pixel looks, with the derivative that carries pixel noise there.
struct PixelBearing {
  Vector3d bearing;           ///< unit vector of the camera
  Matrix<2, 3> J_px_bearing;  ///< d pixel / d direction at the bearing; times the bearing it is 0
};

/// The shortest step of a point that moves its pixel by one, by axis, from d pixel / d point: it is
/// across the ray.
inline Matrix<3, 2> AcrossRay(const Matrix<2, 3>& J_px_p) {
  const Matrix2d square = J_px_p * J_px_p.transpose();
  return J_px_p.transpose() * square.inverse();
}

/// Thread-safe (immutable).
class CameraModel {
 public:
  /// An empty message means that the numbers describe a usable camera.
  static std::string WhatIsWrong(const CameraIntrinsics& k);

  CameraModel() = default;
  /// CHECKs that WhatIsWrong(k) is empty.
  explicit CameraModel(const CameraIntrinsics& k);

  const CameraIntrinsics& intrinsics() const { return k_; }
  int width() const { return k_.width; }
  int height() const { return k_.height; }
  /// Pixels per radian at the optical axis.
  double mean_focal_px() const { return mean_focal_px_; }

  /// Pixel of a point in the camera frame; empty outside the field of view, that is where the
  /// distortion folds over, and more than 85 deg away from the axis, or 110 deg where the lens is
  /// described by directions (wide_lens.h). The pixel may lie outside the image. J: d pixel / d
  /// p_C.
  std::optional<Vector2d> Project(const Vector3d& p_C, Matrix<2, 3>* J = nullptr) const;

  /// Inverse of Project onto the unit sphere, to 1e-9; empty where no ray inside the field of view
  /// of Project has this pixel.
  std::optional<PixelBearing> BearingOf(const Vector2d& px) const;

  /// The bearing alone.
  std::optional<Vector3d> Unproject(const Vector2d& px) const;

  /// Largest angle between a ray and the optical axis that this model can project [rad].
  double max_angle() const { return max_angle_; }

  /// Whether px lies inside the image with `border` pixels to spare.
  bool IsInside(const Vector2d& px, double border) const {
    return px.x() >= border && px.y() >= border && px.x() <= k_.width - 1 - border &&
           px.y() <= k_.height - 1 - border;
  }

 private:
  std::optional<Vector2d> ProjectWidely(const Vector3d& p_C, Matrix<2, 3>* J) const;
  std::optional<PixelBearing> WideBearingOf(const Vector2d& xy_d) const;

  CameraIntrinsics k_;
  double mean_focal_px_ = 0;
  double max_angle_ = 0;
  double max_radius_ = 0;       // the same on the plane z = 1; only where the lens moves its points
  double max_seen_radius_ = 0;  // to which the radial distortion moves max_radius_
  double min_cosine_ = 0;       // of max_angle_
};

}  // namespace facet
