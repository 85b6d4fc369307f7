// SPDX-License-Identifier: BSD-2-Clause
// FAST corners of a small part of an image (Rosten and Drummond, "Machine learning for high-speed
// corner detection", ECCV 2006).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <opencv2/core.hpp>

#include "facet/frontend/patch_kernels.h"

namespace facet {

struct FastCorner {
  int x = 0, y = 0;  ///< in the image
  int score = 0;     ///< the highest threshold at which it is a corner
};

/// Finds pixels of which nine neighbours in a row, on a circle of radius 3, are all brighter or all
/// darker by more than a threshold, and whose score is higher than those of the eight pixels around
/// them. What lies outside the part that is searched has no score. Corners and scores are those of
/// OpenCV's FAST with non-maximum suppression, which is made for whole images. Keeps its buffers;
/// not thread-safe.
class FastCorners {
 public:
  static constexpr int kRadius = 3;
  static constexpr int kMinWidth = 16 + 2 * kRadius;

  /// Row by row; valid until the next call. CHECKs that the image has kRadius pixels around the
  /// cell and is at least kMinWidth wide, and that the threshold is 1 to 255.
  std::span<const FastCorner> Find(const ImageLevel& image, const cv::Rect& cell, int threshold);

 private:
  void FillScores(const ImageLevel& image, const cv::Rect& cell, int threshold);
  std::uint8_t* ScoresOfRow(int y) { return scores_.data() + (y + 1) * stride_ + 1; }

  int stride_ = 0;
  std::vector<std::uint8_t> scores_;  // of the cell, with a border of zeros
  std::vector<FastCorner> corners_;
};

}  // namespace facet
