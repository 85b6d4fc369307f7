// SPDX-License-Identifier: BSD-2-Clause
#pragma once

#include <string>

#include <opencv2/core.hpp>

namespace facet {

/// A grey 8-bit image as a JPEG file. `quality`: 1 to 100. Empty for an empty image.
std::string EncodeJpeg(const cv::Mat& grey, int quality);

}  // namespace facet
