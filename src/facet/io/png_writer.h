// SPDX-License-Identifier: BSD-2-Clause
// Images to PNG files.
#pragma once

#include <filesystem>

#include <opencv2/core.hpp>

namespace facet {

/// Lossless, with fast rather than strong compression. CHECKs that the image is 8-bit grey or RGB,
/// in this order. Throws OutputError when the file cannot be written completely.
void WritePng(const std::filesystem::path& file, const cv::Mat& image);

}  // namespace facet
