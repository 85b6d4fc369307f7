// SPDX-License-Identifier: BSD-2-Clause
// Image files to 8-bit grey: PNG (1-16 bit; grey, colour, palette, alpha), JPEG, WebP, PGM (P2,
// P5). OpenCV's imgcodecs is not used: it links gdal and poppler into the program.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include <opencv2/core.hpp>

namespace facet {

/// Decodes one file after the other and keeps its buffers. Not thread-safe.
class ImageReader {
 public:
  /// Decodes the file into `image` (CV_8UC1). Colour becomes 0.299 R + 0.587 G + 0.114 B, alpha is
  /// ignored, 16 bits become 8 by scaling. The format is told by the content, not by the extension.
  ///
  /// The pixels of `image` are overwritten in place if the size fits and no other cv::Mat shares
  /// them. Throws InputError naming the file when it is missing, truncated, damaged or of another
  /// format, or has more than 64 megapixels; `image` then has undefined content.
  void Read(const std::filesystem::path& file, cv::Mat& image);

  /// The same for an image that must have a certain size; an empty one means any. Returns the size
  /// that the file's header says. If that is another one, nothing is decoded and `image` stays as
  /// it is. Of 16-bit PNG samples the lower `sample_bits` are used (sample_depth.h).
  cv::Size ReadOfSize(const std::filesystem::path& file,
                      const cv::Size& size,
                      cv::Mat& image,
                      int sample_bits = 16);

  /// The same for the content of such a file; the messages do not name it.
  cv::Size DecodeOfSize(std::span<const std::uint8_t> file,
                        const cv::Size& size,
                        cv::Mat& image,
                        int sample_bits = 16);

  /// The largest sample of a PNG with 16 bits, 0 for any other image. Throws InputError as Read
  /// does.
  std::uint16_t LargestSample(const std::filesystem::path& file);

  /// The same for the content of such a file; the messages do not name it.
  std::uint16_t LargestSampleOf(std::span<const std::uint8_t> file);

 private:
  std::vector<std::uint8_t> bytes_;
  std::vector<std::uint8_t> colour_;
};

}  // namespace facet
