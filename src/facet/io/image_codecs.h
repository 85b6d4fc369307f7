// SPDX-License-Identifier: BSD-2-Clause
// The decoders behind ImageReader. Each gets a whole file in memory, throws InputError with the
// reason (without the file's name), and calls PrepareGrey for its output.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <opencv2/core.hpp>

namespace facet {

using Bytes = std::span<const std::uint8_t>;

/// Gives `image` this size and 8-bit grey; keeps its memory if it fits and nobody else uses it.
/// Throws InputError for sizes outside of 1..16384.
void PrepareGrey(std::int64_t width, std::int64_t height, cv::Mat& image);

/// Luma of 8-bit interleaved pixels; equal channels give exactly that value.
/// `red`, `green`, `blue` are offsets within a pixel of `stride` bytes.
struct PixelLayout {
  int stride, red, green, blue;
};
void ColourRowToGrey(const std::uint8_t* row,
                     const PixelLayout& layout,
                     int width,
                     std::uint8_t* grey);

/// `colour` is scratch memory, kept for the next image.
void DecodePng(Bytes file, std::vector<std::uint8_t>& colour, cv::Mat& image);
void DecodeJpeg(Bytes file, cv::Mat& image);
void DecodeWebp(Bytes file, std::vector<std::uint8_t>& colour, cv::Mat& image);
void DecodePgm(Bytes file, cv::Mat& image);

}  // namespace facet
