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
  explicit FileImage(std::filesystem::path file) : file_(std::move(file)) {}
  cv::Size Decode(const cv::Size& wanted, ImageReader& reader, cv::Mat& grey) const override {
    return reader.ReadOfSize(file_, wanted, grey);
  }
  std::string Place() const override { return file_.string(); }

 private:
  std::filesystem::path file_;
};

}  // namespace facet
