// SPDX-License-Identifier: BSD-2-Clause
#include "facet/camera/image_extent.h"

#include <cmath>

namespace facet {
namespace {

constexpr double kPixels = 752 * 480, kFocal_px = 457.975;

}  // namespace

double RelativeImageSide(const CameraModel& camera) {
  constexpr int kSamples = 32;  // along each side
  int num_seen = 0;
  for (int i = 0; i < kSamples; ++i) {
    for (int j = 0; j < kSamples; ++j) {
      const Vector2d px((i + 0.5) / kSamples * camera.width() - 0.5,
                        (j + 0.5) / kSamples * camera.height() - 0.5);
      if (camera.BearingOf(px)) ++num_seen;
    }
  }
  const double num_pixels = static_cast<double>(camera.width()) * camera.height();
  return std::sqrt(num_pixels / kPixels * num_seen / (kSamples * kSamples));
}

double RelativeViewAngle(const CameraModel& camera) {
  return RelativeImageSide(camera) * kFocal_px / camera.mean_focal_px();
}

}  // namespace facet
