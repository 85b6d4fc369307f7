// SPDX-License-Identifier: BSD-2-Clause
// Cameras of any resolution with the lenses of DistortionModel. Images are never rectified: points
// are undistorted.
#pragma once

#include <cmath>
#include <optional>
#include <string>

#include "facet/base/types.h"
#include "facet/camera/camera_intrinsics.h"

namespace facet {

/// Along z [m]: what is nearer than this is beside, behind or on the lens and counts as not in
/// view.
inline constexpr double kMinDepth_m = 0.05;

/// A point on the plane z = 1 of the camera, with the derivative that carries pixel noise there.
struct UndistortedPoint {
  Vector2d xy;       ///< x/z, y/z
  Matrix2d J_xy_px;  ///< d xy / d pixel
};

/// The direction in which a pixel looks, with the derivative that carries pixel noise there.
struct PixelBearing {
  Vector3d bearing;           ///< unit vector of the camera
  Matrix<2, 3> J_px_bearing;  ///< d pixel / d direction at the bearing; times the bearing it is 0
};

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

  /// Pixel of a point in the camera frame; empty outside the field of view, that is behind the
  /// camera, more than 85 deg away from the axis, or where the distortion polynomial folds over.
  /// The pixel may lie outside the image. J: d pixel / d p_C.
  std::optional<Vector2d> Project(const Vector3d& p_C, Matrix<2, 3>* J = nullptr) const;

  /// Inverse of Project onto the plane z = 1, to 1e-9; empty where no ray inside the field of view
  /// of Project has this pixel.
  std::optional<UndistortedPoint> Undistort(const Vector2d& px) const;

  /// Inverse of Project onto the unit sphere; empty as above.
  std::optional<PixelBearing> BearingOf(const Vector2d& px) const;

  /// The bearing alone.
  std::optional<Vector3d> Unproject(const Vector2d& px) const;

  /// Largest angle between a ray and the optical axis that this model can project [rad].
  double max_angle() const { return std::atan(max_radius_); }

  /// Whether px lies inside the image with `border` pixels to spare.
  bool IsInside(const Vector2d& px, double border) const {
    return px.x() >= border && px.y() >= border && px.x() <= k_.width - 1 - border &&
           px.y() <= k_.height - 1 - border;
  }

 private:
  CameraIntrinsics k_;
  double mean_focal_px_ = 0;
  double max_radius_ = 0;  // field of view: largest |xy| on the plane z = 1
};

}  // namespace facet
