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

/// Where an image goes.
struct GreyTarget {
  cv::Mat& image;
  cv::Size wanted;       ///< empty: any size
  int sample_bits = 16;  ///< used of samples with 16
  cv::Size found{};      ///< by the file's header
};

/// What the header says, before memory is taken: false where the size is not the wanted one, and
/// nothing is to be decoded. Otherwise gives the image this size and 8-bit grey; keeps its memory
/// if it fits and nobody else uses it. Throws InputError for sides outside of 1..16384 and for more
/// than 64 megapixels.
bool PrepareGrey(std::int64_t width, std::int64_t height, GreyTarget& target);

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
std::uint16_t LargestPngSample(Bytes file, std::vector<std::uint8_t>& colour);
void DecodePng(Bytes file, std::vector<std::uint8_t>& colour, GreyTarget& target);
void DecodeJpeg(Bytes file, GreyTarget& target);
void DecodeWebp(Bytes file, std::vector<std::uint8_t>& colour, GreyTarget& target);
void DecodePgm(Bytes file, GreyTarget& target);

}  // namespace facet
