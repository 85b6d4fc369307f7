// SPDX-License-Identifier: BSD-2-Clause
#include "facet/messages/message_image.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "facet/io/errors.h"
#include "facet/io/image_codecs.h"
#include "facet/io/sample_depth.h"

namespace facet {
namespace {

enum class Pixels { kGrey, kColour, kLuma, kBayer };

struct Encoding {
  const char* name;
  Pixels pixels;
  int bytes_per_sample;
  PixelLayout layout{1, 0, 0, 0};  // of colour; of luma: stride, and where it begins
  int bayer = 0;                   // OpenCV's code
};

constexpr PixelLayout kRgb{3, 0, 1, 2}, kBgr{3, 2, 1, 0}, kRgba{4, 0, 1, 2}, kBgra{4, 2, 1, 0};
constexpr PixelLayout kUyvy{2, 1, 1, 1}, kYuyv{2, 0, 0, 0}, kOne{1, 0, 0, 0};

// OpenCV names a Bayer pattern after its second row and column.
constexpr std::array kEncodings = {
    Encoding{"mono8", Pixels::kGrey, 1},
    Encoding{"8UC1", Pixels::kGrey, 1},
    Encoding{"mono16", Pixels::kGrey, 2},
    Encoding{"16UC1", Pixels::kGrey, 2},
    Encoding{"rgb8", Pixels::kColour, 1, kRgb},
    Encoding{"bgr8", Pixels::kColour, 1, kBgr},
    Encoding{"8UC3", Pixels::kColour, 1, kBgr},
    Encoding{"rgba8", Pixels::kColour, 1, kRgba},
    Encoding{"bgra8", Pixels::kColour, 1, kBgra},
    Encoding{"8UC4", Pixels::kColour, 1, kBgra},
    Encoding{"yuv422", Pixels::kLuma, 1, kUyvy},
    Encoding{"uyvy", Pixels::kLuma, 1, kUyvy},
    Encoding{"yuv422_yuy2", Pixels::kLuma, 1, kYuyv},
    Encoding{"yuyv", Pixels::kLuma, 1, kYuyv},
    Encoding{"bayer_rggb8", Pixels::kBayer, 1, kOne, cv::COLOR_BayerBG2GRAY},
    Encoding{"bayer_bggr8", Pixels::kBayer, 1, kOne, cv::COLOR_BayerRG2GRAY},
    Encoding{"bayer_gbrg8", Pixels::kBayer, 1, kOne, cv::COLOR_BayerGR2GRAY},
    Encoding{"bayer_grbg8", Pixels::kBayer, 1, kOne, cv::COLOR_BayerGB2GRAY},
    Encoding{"bayer_rggb16", Pixels::kBayer, 2, kOne, cv::COLOR_BayerBG2GRAY},
    Encoding{"bayer_bggr16", Pixels::kBayer, 2, kOne, cv::COLOR_BayerRG2GRAY},
    Encoding{"bayer_gbrg16", Pixels::kBayer, 2, kOne, cv::COLOR_BayerGR2GRAY},
    Encoding{"bayer_grbg16", Pixels::kBayer, 2, kOne, cv::COLOR_BayerGB2GRAY},
};

const Encoding* FindEncoding(const std::string& name) {
  const auto found = std::ranges::find_if(
      kEncodings, [&](const Encoding& encoding) { return name == encoding.name; });
  return found == kEncodings.end() ? nullptr : &*found;
}

const Encoding& RequireEncoding(const std::string& name) {
  if (const Encoding* found = FindEncoding(name)) return *found;
  std::string known;
  for (const Encoding& encoding : kEncodings)
    known += std::string(known.empty() ? "" : ", ") + encoding.name;
  throw InputError("images are encoded as '" + name + "'; known are " + known);
}

std::uint64_t BytesPerRow(const Encoding& encoding, std::uint32_t width) {
  return std::uint64_t{width} * static_cast<std::uint64_t>(encoding.layout.stride) *
         static_cast<std::uint64_t>(encoding.bytes_per_sample);
}

void CheckData(const ImageMessage& message, const Encoding& encoding) {
  const std::uint64_t row = BytesPerRow(encoding, message.width);
  const std::uint64_t needed = std::uint64_t{message.step} * (message.height - 1) + row;
  if (message.step < row || message.data.size() < needed) {
    throw InputError("an image of " + std::to_string(message.width) + " x " +
                     std::to_string(message.height) + " pixels in " + encoding.name + ", rows of " +
                     std::to_string(message.step) + " bytes, has only " +
                     std::to_string(message.data.size()) + " bytes; the message is damaged");
  }
}

std::uint32_t Sample16(const std::uint8_t* row, int x, bool is_big_endian) {
  const std::uint32_t first = row[2 * x], second = row[2 * x + 1];
  return is_big_endian ? first << 8 | second : second << 8 | first;
}

void RowToGrey(const ImageMessage& message,
               const Encoding& encoding,
               int bits,
               const std::uint8_t* row,
               int width,
               std::uint8_t* grey) {
  if (encoding.bytes_per_sample == 2) {
    for (int x = 0; x < width; ++x)
      grey[x] = ToEightBits(Sample16(row, x, message.is_big_endian), bits);
  } else if (encoding.pixels == Pixels::kColour) {
    ColourRowToGrey(row, encoding.layout, width, grey);
  } else if (encoding.pixels == Pixels::kLuma) {
    for (int x = 0; x < width; ++x)
      grey[x] = row[encoding.layout.stride * x + encoding.layout.red];
  } else {
    std::copy_n(row, width, grey);
  }
}

void DecodeRaw(const ImageMessage& message, int bits, GreyTarget& target) {
  const Encoding& encoding = RequireEncoding(message.encoding);
  if (!PrepareGrey(message.width, message.height, target)) return;
  CheckData(message, encoding);
  cv::Mat& image = target.image;
  for (int y = 0; y < image.rows; ++y) {
    const std::uint8_t* row =
        message.data.data() + std::size_t{message.step} * static_cast<std::size_t>(y);
    RowToGrey(message, encoding, bits, row, image.cols, image.ptr(y));
  }
  if (encoding.pixels != Pixels::kBayer) return;
  constexpr int kMinSide = 4;  // below it there is nothing to interpolate
  if (image.rows < kMinSide || image.cols < kMinSide)
    throw InputError("a Bayer image of a few pixels");
  cv::Mat grey;
  cv::cvtColor(image, grey, encoding.bayer);
  grey.copyTo(image);
}

}  // namespace

cv::Size DecodeToGrey(const ImageMessage& message,
                      int bits,
                      const cv::Size& wanted,
                      ImageReader& reader,
                      cv::Mat& grey) {
  if (message.encoding.empty()) return reader.DecodeOfSize(message.data, wanted, grey, bits);
  GreyTarget target{grey, wanted};
  DecodeRaw(message, bits, target);
  return target.found;
}

MessageImage::MessageImage(const ImageMessage& message, int bits, std::string place)
    : message_(message),
      data_(message.data.begin(), message.data.end()),
      bits_(bits),
      place_(std::move(place)) {
  message_.data = data_;
}

cv::Size MessageImage::Decode(const cv::Size& wanted, ImageReader& reader, cv::Mat& grey) const {
  try {
    return DecodeToGrey(message_, bits_, wanted, reader, grey);
  } catch (const InputError& error) {
    throw InputError(place_ + ": " + error.what());
  }
}

std::uint16_t LargestSample(const ImageMessage& message, ImageReader& reader) {
  if (message.encoding.empty()) return reader.LargestSampleOf(message.data);
  const Encoding* encoding = FindEncoding(message.encoding);
  if (encoding == nullptr || encoding->bytes_per_sample != 2) return 0;
  std::uint32_t max = 0;
  for (std::size_t i = 0; i + 1 < message.data.size(); i += 2) {
    max = std::max(max, Sample16(message.data.data() + i, 0, message.is_big_endian));
  }
  return static_cast<std::uint16_t>(max);
}

}  // namespace facet
