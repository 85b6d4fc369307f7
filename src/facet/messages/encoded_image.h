// SPDX-License-Identifier: BSD-2-Clause
// An image as it lies in a recording: a file, or bytes of a message.
#pragma once

#include <filesystem>
#include <string>

#include <opencv2/core.hpp>

#include "facet/io/image_reader.h"

namespace facet {

/// Thread-safe (immutable).
class EncodedImage {
 public:
  virtual ~EncodedImage() = default;

  /// Decodes to 8-bit grey. If `wanted` is not empty and the image has another size, nothing is
  /// decoded. Returns the size that the image has. Throws InputError, naming the place, when the
  /// image is damaged or of an unknown format.
  virtual cv::Size Decode(const cv::Size& wanted, ImageReader& reader, cv::Mat& grey) const = 0;

  /// Where it lies, for messages.
  virtual std::string Place() const = 0;
};

class FileImage : public EncodedImage {
 public:
  /// `sample_bits` is how many of 16-bit samples are used.
  explicit FileImage(std::filesystem::path file, int sample_bits = 16)
      : file_(std::move(file)), sample_bits_(sample_bits) {}
  cv::Size Decode(const cv::Size& wanted, ImageReader& reader, cv::Mat& grey) const override {
    return reader.ReadOfSize(file_, wanted, grey, sample_bits_);
  }
  std::string Place() const override { return file_.string(); }

 private:
  std::filesystem::path file_;
  int sample_bits_;
};

}  // namespace facet
