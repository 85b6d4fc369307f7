// SPDX-License-Identifier: BSD-2-Clause
// Pinhole cameras with radial-tangential (OpenCV, Kalibr "radtan") or equidistant (Kannala-Brandt,
// Kalibr "equidistant") distortion, any resolution. Images are never rectified: points are
// undistorted.
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <string>

#include "facet/base/types.h"

namespace facet {

/// Along z [m]: what is nearer than this is beside, behind or on the lens and counts as not in
/// view.
inline constexpr double kMinDepth_m = 0.05;

enum class DistortionModel { kNone, kRadialTangential, kEquidistant };

/// Plain numbers of one camera, as in a calibration file.
struct CameraIntrinsics {
  int width = 0;   ///< pixels
  int height = 0;  ///< pixels
  double fx = 0, fy = 0, cx = 0, cy = 0;
  DistortionModel distortion = DistortionModel::kNone;
  /// k1 k2 p1 p2 (radial-tangential) or k1 k2 k3 k4 (equidistant).
  std::array<double, 4> coefficients{};
};

/// A point on the plane z = 1 of the camera, with the derivative that carries pixel noise there.
struct UndistortedPoint {
  Vector2d xy;       ///< x/z, y/z
  Matrix2d J_xy_px;  ///< d xy / d pixel
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
  double mean_focal_px() const { return 0.5 * (k_.fx + k_.fy); }

  /// Pixel of a point in the camera frame; empty outside the field of view, that is behind the
  /// camera, more than 85 deg away from the axis, or where the distortion polynomial folds over.
  /// The pixel may lie outside the image. J: d pixel / d p_C.
  std::optional<Vector2d> Project(const Vector3d& p_C, Matrix<2, 3>* J = nullptr) const;

  /// Inverse of Project onto the plane z = 1, to 1e-9; empty where no ray inside the field of view
  /// of Project has this pixel.
  std::optional<UndistortedPoint> Undistort(const Vector2d& px) const;

  /// Unit bearing of a pixel.
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
  double max_radius_ = 0;  // field of view: largest |xy| on the plane z = 1
};

}  // namespace facet
