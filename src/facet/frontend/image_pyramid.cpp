// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/image_pyramid.h"

#include "facet/base/check.h"

namespace facet {
namespace {

constexpr int kMinSide = 16;

ImageLevel View(const cv::Mat& image) {
  return {image.data, static_cast<int>(image.step[0]), image.cols, image.rows};
}

}  // namespace

void ImagePyramid::Build(const cv::Mat& image, int num_levels) {
  FACET_CHECK(image.type() == CV_8UC1 && !image.empty()) << "a pyramid needs an 8 bit grey image";
  FACET_CHECK(num_levels >= 1) << num_levels;
  images_.resize(static_cast<std::size_t>(num_levels));
  levels_.clear();
  images_[0] = image;
  levels_.push_back(View(image));
  for (std::size_t l = 1; l < images_.size(); ++l) {
    const cv::Mat& above = images_[l - 1];
    if (above.cols < 2 * kMinSide || above.rows < 2 * kMinSide) break;
    halver_.Halve(above, images_[l]);
    levels_.push_back(View(images_[l]));
  }
}

void ImagePyramid::Clear() {
  if (!images_.empty()) images_[0].release();
  levels_.clear();
}

}  // namespace facet
