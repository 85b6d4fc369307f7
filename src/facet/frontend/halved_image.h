// SPDX-License-Identifier: BSD-2-Clause
// The next level of an image pyramid.
#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core.hpp>

namespace facet {

/// Halves 8 bit grey images: every second pixel of what the binomial filter (1 4 6 4 1) / 16 makes
/// of rows and columns; beyond its border an image goes on as its mirror. These are the pixels of
/// OpenCV's pyrDown; sums of 25 pixels fit into 16 bits. Keeps its buffers
/// from image to image. Not thread-safe.
class ImageHalver {
 public:
  /// Adds so many numbers at once, 16 or 8, or what the processor can. The pixels are the same.
  explicit ImageHalver(int max_at_once = 16) : max_at_once_(max_at_once) {}

  /// `half` gets (w + 1) / 2 x (h + 1) / 2 pixels, in its old memory if it had that size before.
  /// CHECKs that both sides of `image` have 4 pixels.
  void Halve(const cv::Mat& image, cv::Mat& half);

 private:
  int max_at_once_;
  std::vector<std::uint16_t> even_, odd_;  // columns of a row after the vertical filter
};

}  // namespace facet
