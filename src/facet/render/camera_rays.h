// SPDX-License-Identifier: BSD-2-Clause
// The ray of every pixel through the exact distorted camera model, or through a lens that does not
// quite obey it.
#pragma once

#include <vector>

#include "facet/calibration/lens_misfit.h"
#include "facet/camera/camera_model.h"

namespace facet {

/// Thread-safe (immutable).
class CameraRays {
 public:
  explicit CameraRays(const CameraModel& camera);
  /// With a lens that does not obey its model.
  CameraRays(const CameraModel& camera, const LensMisfit& misfit);

  int width() const { return width_; }
  int height() const { return height_; }

  /// Direction, of any length, through pixel (x, y) plus an offset of at most a few pixels. The
  /// offset is carried there by the derivative of the lens, with an error below 0.01 px for offsets
  /// up to 1 px.
  Eigen::Vector3f At(int x, int y, const Eigen::Vector2f& offset_px) const {
    const Ray& ray = rays_[static_cast<std::size_t>(y * width_ + x)];
    return ray.direction + offset_px.x() * ray.by_x + offset_px.y() * ray.by_y;
  }
  bool IsValid(int x, int y) const {
    return rays_[static_cast<std::size_t>(y * width_ + x)].is_valid;
  }

  /// Share of the light that arrives at a pixel: the cos^4 law, cos sin(x)/x for fisheyes.
  float Vignette(int x, int y) const {
    return rays_[static_cast<std::size_t>(y * width_ + x)].vignette;
  }
  /// Angle that a pixel covers in the middle of the image [rad].
  float pixel_angle() const { return pixel_angle_; }

 private:
  template <class PixelOfModel>
  CameraRays(const CameraModel& camera, const PixelOfModel& pixel_of_model);

  struct Ray {
    Eigen::Vector3f direction = Eigen::Vector3f::Zero();
    Eigen::Vector3f by_x = Eigen::Vector3f::Zero(), by_y = Eigen::Vector3f::Zero();  // per pixel
    float vignette = 0;
    bool is_valid = false;
  };

  int width_ = 0, height_ = 0;
  float pixel_angle_ = 0;
  std::vector<Ray> rays_;
};

}  // namespace facet
