// SPDX-License-Identifier: BSD-2-Clause
// Images of ROS messages to 8-bit grey.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "facet/messages/encoded_image.h"
#include "facet/messages/ros_messages.h"

namespace facet {

/// Decodes to 8-bit grey what MessageImage understands. If `wanted` is not empty and the image has
/// another size, nothing is decoded. Returns the size that the image has. `bits` is how many of
/// 16-bit samples are used. Throws InputError, without a place, when the image is damaged or of an
/// unknown encoding.
cv::Size DecodeToGrey(const ImageMessage& message,
                      int bits,
                      const cv::Size& wanted,
                      ImageReader& reader,
                      cv::Mat& grey);

/// Keeps a copy of the pixels.
class MessageImage : public EncodedImage {
 public:
  /// `bits` is how many of 16-bit samples are used; `place` is for messages.
  MessageImage(const ImageMessage& message, int bits, std::string place);
  MessageImage(const MessageImage&) = delete;  // the message points into the copy
  MessageImage& operator=(const MessageImage&) = delete;

  /// Understands files (PNG, JPEG, WebP, PGM) and the encodings mono8, mono16, 8UC1, 16UC1, rgb8,
  /// bgr8, rgba8, bgra8, 8UC3, 8UC4 (as bgr8, bgra8), yuv422 (uyvy), yuv422_yuy2 (yuyv), and
  /// bayer_rggb8 and its kin with 8 or 16 bits, which become grey by bilinear interpolation.
  cv::Size Decode(const cv::Size& wanted, ImageReader& reader, cv::Mat& grey) const override;
  std::string Place() const override { return place_; }

 private:
  ImageMessage message_;
  std::vector<std::uint8_t> data_;
  int bits_;
  std::string place_;
};

/// The largest value of an image with 16-bit samples, also of a PNG, 0 for any other one. Throws
/// InputError for a damaged file.
std::uint16_t LargestSample(const ImageMessage& message, ImageReader& reader);

}  // namespace facet
