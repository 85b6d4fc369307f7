// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/image_reader.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <string>
#include <string_view>
#include <system_error>

#include "facet/io/errors.h"
#include "facet/io/grey_png.h"
#include "facet/io/image_codecs.h"

namespace facet {
namespace {

void ReadFile(const std::filesystem::path& file, std::vector<std::uint8_t>& bytes) {
  std::error_code error;
  const auto size = std::filesystem::file_size(file, error);
  if (error) throw InputError(error.message());
  if (size == 0) throw InputError("the file is empty");
  bytes.resize(size);
  std::ifstream stream(file, std::ios::binary);
  // The stream takes char where the decoders take bytes; both are the same octets.
  stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  if (!stream) throw InputError("cannot be read (permissions?)");
}

bool HasMagic(Bytes bytes, std::size_t offset, std::string_view magic) {
  return bytes.size() >= offset + magic.size() &&
         std::equal(magic.begin(),
                    magic.end(),
                    bytes.begin() + static_cast<std::ptrdiff_t>(offset),
                    [](char a, std::uint8_t b) { return static_cast<std::uint8_t>(a) == b; });
}

[[noreturn]] void ThrowUnknownFormat(Bytes bytes) {
  std::string first;
  for (std::size_t i = 0; i < std::min<std::size_t>(4, bytes.size()); ++i) {
    char hex[8];
    std::snprintf(hex, sizeof(hex), " %02X", static_cast<unsigned>(bytes[i]));
    first += hex;
  }
  throw InputError("not a PNG, JPEG, WebP or PGM image (begins with bytes" + first +
                   "); convert it to PNG");
}

bool IsPng(Bytes bytes) {
  using std::string_view_literals::operator""sv;
  return HasMagic(bytes, 0, "\x89PNG\r\n\x1A\n"sv);
}

void Decode(Bytes bytes, std::vector<std::uint8_t>& colour, GreyTarget& target) {
  using std::string_view_literals::operator""sv;
  if (IsPng(bytes)) {
    if (!DecodeGreyPng(bytes, colour, target)) DecodePng(bytes, colour, target);
  } else if (HasMagic(bytes, 0, "\xFF\xD8\xFF"sv)) {
    DecodeJpeg(bytes, target);
  } else if (HasMagic(bytes, 0, "RIFF"sv) && HasMagic(bytes, 8, "WEBP"sv)) {
    DecodeWebp(bytes, colour, target);
  } else if (HasMagic(bytes, 0, "P5"sv) || HasMagic(bytes, 0, "P2"sv)) {
    DecodePgm(bytes, target);
  } else {
    ThrowUnknownFormat(bytes);
  }
}

}  // namespace

void ImageReader::Read(const std::filesystem::path& file, cv::Mat& image) {
  ReadOfSize(file, cv::Size(), image);
}

cv::Size ImageReader::ReadOfSize(const std::filesystem::path& file,
                                 const cv::Size& size,
                                 cv::Mat& image,
                                 int sample_bits) {
  GreyTarget target{image, size, sample_bits};
  try {
    ReadFile(file, bytes_);
    Decode(bytes_, colour_, target);
  } catch (const InputError& error) {
    throw InputError(file.string() + ": " + error.what());
  }
  return target.found;
}

cv::Size ImageReader::DecodeOfSize(Bytes file,
                                   const cv::Size& size,
                                   cv::Mat& image,
                                   int sample_bits) {
  GreyTarget target{image, size, sample_bits};
  Decode(file, colour_, target);
  return target.found;
}

std::uint16_t ImageReader::LargestSample(const std::filesystem::path& file) {
  try {
    ReadFile(file, bytes_);
    return LargestSampleOf(bytes_);
  } catch (const InputError& error) {
    throw InputError(file.string() + ": " + error.what());
  }
}

std::uint16_t ImageReader::LargestSampleOf(Bytes file) {
  return IsPng(file) ? LargestPngSample(file, colour_) : std::uint16_t{0};
}

}  // namespace facet
