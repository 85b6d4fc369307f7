// SPDX-License-Identifier: BSD-2-Clause
#include "facet/render/image_sensor.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace facet {
namespace {

/// Normal numbers from a table: one multiplication per pixel instead of a logarithm.
class NormalTable {
 public:
  NormalTable() {
    Rng rng(1);
    for (float& value : values_)
      value = static_cast<float>(rng.Normal());
  }
  float operator[](std::uint64_t index) const { return values_[index % kSize]; }

 private:
  static constexpr std::size_t kSize = 65536;
  std::array<float, kSize> values_{};
};

}  // namespace

cv::Mat1b ExposeSensor(const cv::Mat1f& radiance,
                       const CameraRays& camera,
                       double gain,
                       const ImageSensorOptions& options,
                       Rng rng) {
  static const NormalTable normals;
  cv::Mat1b image(radiance.size());
  const auto vignetting = static_cast<float>(options.vignetting);
  const auto read_variance = static_cast<float>(options.read_noise * options.read_noise);
  const auto shot = static_cast<float>(options.shot_noise);
  const auto black = static_cast<float>(options.black_level);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const float share = 1 - vignetting * (1 - camera.Vignette(x, y));
      const float level = share * static_cast<float>(gain) * radiance(y, x);
      float noisy = black + level;
      if (options.add_noise) {
        // The sensor is full at white: brighter light has no more noise.
        const float variance = read_variance + shot * std::min(level, 255.0F);
        noisy += std::sqrt(variance) * normals[rng.Next() >> 40];
      }
      image(y, x) = static_cast<std::uint8_t>(std::clamp(noisy + 0.5F, 0.0F, 255.0F));
    }
  }
  return image;
}

}  // namespace facet
