// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/png_writer.h"

#include <cstdio>
#include <memory>

#include <png.h>

#include "facet/base/check.h"
#include "facet/io/errors.h"

namespace facet {
namespace {

void ThrowPngError(png_structp /*png*/, png_const_charp message) {
  throw OutputError(message);
}

void IgnorePngWarning(png_structp /*png*/, png_const_charp /*message*/) {}

/// Owns libpng's two structs.
struct PngWriter {
  png_structp png = nullptr;
  png_infop info = nullptr;
  PngWriter() {
    png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, ThrowPngError, IgnorePngWarning);
    if (png) info = png_create_info_struct(png);
    if (!info) throw OutputError("not enough memory");
  }
  PngWriter(const PngWriter&) = delete;
  PngWriter& operator=(const PngWriter&) = delete;
  ~PngWriter() { png_destroy_write_struct(&png, &info); }
};

void Encode(std::FILE* stream, const cv::Mat& image) {
  PngWriter writer;
  png_init_io(writer.png, stream);
  png_set_IHDR(writer.png,
               writer.info,
               static_cast<png_uint_32>(image.cols),
               static_cast<png_uint_32>(image.rows),
               8,
               image.channels() == 1 ? PNG_COLOR_TYPE_GRAY : PNG_COLOR_TYPE_RGB,
               PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_set_compression_level(writer.png, 1);
  png_set_filter(writer.png, 0, PNG_FILTER_SUB);
  png_write_info(writer.png, writer.info);
  for (int y = 0; y < image.rows; ++y)
    png_write_row(writer.png, image.ptr(y));
  png_write_end(writer.png, writer.info);
}

}  // namespace

void WritePng(const std::filesystem::path& file, const cv::Mat& image) {
  FACET_CHECK((image.type() == CV_8UC1 || image.type() == CV_8UC3) && !image.empty())
      << "not an 8-bit grey or RGB image";
  const auto fail = [&](const std::string& reason) {
    throw OutputError(file.string() + ": cannot be written (disk full, permissions?)" + reason);
  };
  std::FILE* stream = std::fopen(file.c_str(), "wb");
  if (!stream) fail("");
  try {
    Encode(stream, image);
  } catch (const OutputError& error) {
    std::fclose(stream);
    fail(std::string(": ") + error.what());
  }
  if (std::fclose(stream) != 0) fail("");
}

}  // namespace facet
