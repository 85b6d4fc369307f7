// SPDX-License-Identifier: BSD-2-Clause
// A grey image with its mip pyramid.
#pragma once

#include <algorithm>
#include <vector>

#include "facet/render/grey_canvas.h"

namespace facet {

/// Repeats in both directions. Thread-safe (immutable).
class Texture {
 public:
  Texture() = default;
  /// Any size; it is brought to the nearest power of two. CHECKs that the canvas is not empty.
  explicit Texture(const GreyCanvas& canvas);

  int width() const { return images_.empty() ? 0 : images_.front().cols; }
  int height() const { return images_.empty() ? 0 : images_.front().rows; }

  /// Albedo 0..1 at (u, v) in units of the image, bilinear in a mip level. A pixel's samples take
  /// turns between the two levels around the one that they want.
  float Sample(float u, float v, int level) const {
    const Level& image = levels_[static_cast<std::size_t>(std::clamp(level, 0, last_level_))];
    const float x = u * image.width - 0.5F, y = v * image.height - 0.5F;
    int left = static_cast<int>(x), top = static_cast<int>(y);
    left -= x < static_cast<float>(left) ? 1 : 0;  // std::floor is a slow call on old processors
    top -= y < static_cast<float>(top) ? 1 : 0;
    const float fx = x - static_cast<float>(left), fy = y - static_cast<float>(top);
    const std::uint8_t* a = image.data + ((top & image.mask_y) << image.shift);
    const std::uint8_t* b = image.data + (((top + 1) & image.mask_y) << image.shift);
    const int x0 = left & image.mask_x, x1 = (left + 1) & image.mask_x;
    const float upper = static_cast<float>(a[x0]) + fx * static_cast<float>(a[x1] - a[x0]);
    const float lower = static_cast<float>(b[x0]) + fx * static_cast<float>(b[x1] - b[x0]);
    return (upper + fy * (lower - upper)) * (1.0F / 255.0F);
  }

 private:
  struct Level {
    const std::uint8_t* data = nullptr;
    float width = 0, height = 0;
    int mask_x = 0, mask_y = 0, shift = 0;
  };

  std::vector<cv::Mat1b> images_;  // sizes are powers of two, each half of the one before
  std::vector<Level> levels_;      // the same, ready for Sample
  int last_level_ = -1;
};

}  // namespace facet
