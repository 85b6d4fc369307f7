// SPDX-License-Identifier: BSD-2-Clause
#include "facet/render/camera_rays.h"

#include <cmath>

namespace facet {
namespace {

bool IsFisheye(DistortionModel model) {
  return model != DistortionModel::kNone && model != DistortionModel::kRadialTangential &&
         model != DistortionModel::kRational;
}

// The light of a ray at an angle from the axis, as a share of that along it: the cosine of the
// angle at which it meets the pupil, times the solid angle that a pixel covers there. That is cos^4
// where a plane is projected, and more where angles are.
double Illumination(DistortionModel model, double tangent_2) {
  const double cosine_2 = 1 / (1 + tangent_2);
  if (!IsFisheye(model)) return cosine_2 * cosine_2;
  const double angle = std::atan(std::sqrt(tangent_2));
  return angle > 0 ? std::sqrt(cosine_2) * std::sin(angle) / angle : 1;
}

}  // namespace

/// `pixel_of_model`: from a pixel of the image to the one that the model gives the same ray.
template <class PixelOfModel>
CameraRays::CameraRays(const CameraModel& camera, const PixelOfModel& pixel_of_model)
    : width_(camera.width()),
      height_(camera.height()),
      pixel_angle_(static_cast<float>(1 / camera.mean_focal_px())),
      rays_(static_cast<std::size_t>(camera.width() * camera.height())) {
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      const auto point = camera.Undistort(pixel_of_model(Vector2d(x, y)));
      if (!point) continue;  // outside the field of view: stays black
      Ray& ray = rays_[static_cast<std::size_t>(y * width_ + x)];
      ray.x = static_cast<float>(point->xy.x());
      ray.y = static_cast<float>(point->xy.y());
      ray.x_dx = static_cast<float>(point->J_xy_px(0, 0));
      ray.x_dy = static_cast<float>(point->J_xy_px(0, 1));
      ray.y_dx = static_cast<float>(point->J_xy_px(1, 0));
      ray.y_dy = static_cast<float>(point->J_xy_px(1, 1));
      ray.vignette =
          static_cast<float>(Illumination(camera.intrinsics().distortion, point->xy.squaredNorm()));
      ray.is_valid = true;
    }
  }
}

CameraRays::CameraRays(const CameraModel& camera)
    : CameraRays(camera, [](const Vector2d& px) { return px; }) {}

CameraRays::CameraRays(const CameraModel& camera, const LensMisfit& misfit)
    : CameraRays(camera, [&](const Vector2d& px) { return misfit.Undo(px); }) {}

}  // namespace facet
