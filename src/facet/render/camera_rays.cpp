// SPDX-License-Identifier: BSD-2-Clause
#include "facet/render/camera_rays.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "facet/camera/wide_lens.h"

namespace facet {
namespace {

// The light of a ray at an angle from the axis, as a share of that along it: the cosine of the
// angle at which it meets the pupil, times the solid angle that a pixel covers there. That is cos^4
// where a plane is projected, and more where angles are.
// Beyond 60 deg the pupil of a fisheye turns along, or nothing would arrive from beside it.
double Illumination(DistortionModel model, const Vector3d& bearing) {
  constexpr double kLeastPupil = 0.5;
  const double cosine = bearing.z();
  if (!IsWideLens(model)) return std::pow(cosine, 4);
  const double sine = bearing.head<2>().norm(), angle = std::atan2(sine, cosine);
  return angle > 0 ? std::max(cosine, kLeastPupil) * sine / angle : 1;
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
      const std::optional<PixelBearing> seen = camera.BearingOf(pixel_of_model(Vector2d(x, y)));
      if (!seen) continue;  // outside the field of view: stays black
      Ray& ray = rays_[static_cast<std::size_t>(y * width_ + x)];
      const Matrix<3, 2> by_pixel = AcrossRay(seen->J_px_bearing);
      ray.direction = seen->bearing.cast<float>();
      ray.by_x = by_pixel.col(0).cast<float>();
      ray.by_y = by_pixel.col(1).cast<float>();
      ray.vignette =
          static_cast<float>(Illumination(camera.intrinsics().distortion, seen->bearing));
      ray.is_valid = true;
    }
  }
}

CameraRays::CameraRays(const CameraModel& camera)
    : CameraRays(camera, [](const Vector2d& px) { return px; }) {}

CameraRays::CameraRays(const CameraModel& camera, const LensMisfit& misfit)
    : CameraRays(camera, [&](const Vector2d& px) { return misfit.Undo(px); }) {}

}  // namespace facet
