// SPDX-License-Identifier: BSD-2-Clause
// For tests: encoders for the image kinds that ImageReader has to understand.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace facet {

/// Interleaved samples, `channels` 1 (grey), 2 (grey, alpha), 3 (RGB), 4 (RGBA). Depth 16 uses
/// 16-bit values.
struct TestImage {
  int width = 0, height = 0, channels = 1;
  std::vector<std::uint16_t> samples;
};

struct PngSettings {
  int depth = 8;  ///< 1, 2, 4, 8, 16
  bool interlaced = false;
  bool palette = false;  ///< the samples are indices into a palette of grey levels 255 - index
  int filters = 0;       ///< to choose from (PNG_FILTER_SUB ...); 0: libpng's choice
  std::size_t chunk_size = 8192;  ///< of the IDAT chunks; 8192 is libpng's
};

std::string EncodePng(const TestImage& image, const PngSettings& settings = {});
std::string EncodeJpeg(const TestImage& image, int quality);  ///< 1 or 3 channels
std::string EncodeWebpLossless(const TestImage& image);       ///< 3 channels

}  // namespace facet
