// SPDX-License-Identifier: BSD-2-Clause
#include "facet/render/texture.h"

#include <algorithm>
#include <bit>

#include <opencv2/imgproc.hpp>

#include "facet/base/check.h"

namespace facet {
namespace {

int NearestPowerOfTwo(int n) {
  const int below = static_cast<int>(std::bit_floor(static_cast<unsigned>(n)));
  return std::min(4096, n - below > below / 2 ? 2 * below : below);
}

}  // namespace

Texture::Texture(const GreyCanvas& canvas) {
  FACET_CHECK(!canvas.empty()) << "a texture needs pixels";
  cv::Mat1f level;
  cv::resize(canvas,
             level,
             {NearestPowerOfTwo(canvas.cols), NearestPowerOfTwo(canvas.rows)},
             0,
             0,
             cv::INTER_AREA);
  while (true) {
    cv::Mat1b bytes;
    level.convertTo(bytes, CV_8U, 255.0);
    images_.push_back(bytes);
    levels_.push_back({bytes.data,
                       static_cast<float>(bytes.cols),
                       static_cast<float>(bytes.rows),
                       bytes.cols - 1,
                       bytes.rows - 1,
                       std::countr_zero(static_cast<unsigned>(bytes.cols))});
    ++last_level_;
    if (level.cols == 1 && level.rows == 1) return;
    cv::Mat1f half;
    cv::resize(level,
               half,
               {std::max(1, level.cols / 2), std::max(1, level.rows / 2)},
               0,
               0,
               cv::INTER_AREA);
    level = half;
  }
}

}  // namespace facet
