// SPDX-License-Identifier: BSD-2-Clause
// A pyramid of halved 8 bit images. Pixel (x, y) of level l lies over pixel (x, y) * 2^l of the
// image.
#pragma once

#include <utility>
#include <vector>

#include <opencv2/core.hpp>

#include "facet/frontend/halved_image.h"
#include "facet/frontend/patch_kernels.h"

namespace facet {

/// Not thread-safe. Keeps its buffers from image to image.
class ImagePyramid {
 public:
  /// References `image` (8 bit grey) as level 0 and halves it num_levels - 1 times, or until a side
  /// would become shorter than 16 pixels.
  void Build(const cv::Mat& image, int num_levels);

  /// Forgets the image, keeps the buffers.
  void Clear();

  bool empty() const { return levels_.empty(); }
  int num_levels() const { return static_cast<int>(levels_.size()); }
  /// The same pixels twice: as an image, and as the kernels read it.
  const cv::Mat& image(int l) const { return images_[static_cast<std::size_t>(l)]; }
  const ImageLevel& level(int l) const { return levels_[static_cast<std::size_t>(l)]; }

 private:
  ImageHalver halver_;
  std::vector<cv::Mat> images_;
  std::vector<ImageLevel> levels_;
};

/// Of an image and of the one before it.
struct PyramidPair {
  ImagePyramid previous, now;

  /// The next image.
  void Build(const cv::Mat& image, int num_levels) {
    std::swap(previous, now);
    now.Build(image, num_levels);
  }
};

}  // namespace facet
