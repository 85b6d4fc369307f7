// SPDX-License-Identifier: BSD-2-Clause
#include "facet/testing/io/test_images.h"

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <stdexcept>

#include <jpeglib.h>
#include <png.h>
#include <webp/encode.h>

namespace facet {
namespace {

void AppendPngBytes(png_structp png, png_bytep data, png_size_t size) {
  static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<char*>(data), size);
}

void ThrowPngError(png_structp /*png*/, png_const_charp message) {
  throw std::runtime_error(message);
}

int PngColorType(const TestImage& image, const PngSettings& settings) {
  if (settings.palette) return PNG_COLOR_TYPE_PALETTE;
  constexpr int kTypes[] = {
      PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_GRAY_ALPHA, PNG_COLOR_TYPE_RGB, PNG_COLOR_TYPE_RGB_ALPHA};
  return kTypes[image.channels - 1];
}

std::vector<std::uint8_t> PngRow(const TestImage& image, int y, int depth) {
  std::vector<std::uint8_t> row;
  const int num = image.width * image.channels;
  for (int i = 0; i < num; ++i) {
    const std::uint16_t v = image.samples[static_cast<std::size_t>(y * num + i)];
    if (depth == 16) row.push_back(static_cast<std::uint8_t>(v >> 8));
    row.push_back(static_cast<std::uint8_t>(v & 255));
  }
  return row;
}

}  // namespace

std::string EncodePng(const TestImage& image, const PngSettings& settings) {
  std::string file;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, ThrowPngError, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(png, &file, AppendPngBytes, nullptr);
  png_set_IHDR(png,
               info,
               static_cast<png_uint_32>(image.width),
               static_cast<png_uint_32>(image.height),
               settings.depth,
               PngColorType(image, settings),
               settings.interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  std::vector<png_color> palette;
  for (int i = 0; i < (1 << std::min(settings.depth, 8)); ++i) {
    const auto grey = static_cast<png_byte>(255 - i);
    palette.push_back({grey, grey, grey});
  }
  if (settings.filters != 0) png_set_filter(png, 0, settings.filters);
  png_set_compression_buffer_size(png, settings.chunk_size);
  if (settings.palette) png_set_PLTE(png, info, palette.data(), static_cast<int>(palette.size()));
  png_write_info(png, info);
  if (settings.depth < 8) png_set_packing(png);
  std::vector<std::vector<std::uint8_t>> rows;
  std::vector<png_bytep> pointers;
  for (int y = 0; y < image.height; ++y)
    rows.push_back(PngRow(image, y, settings.depth));
  for (auto& row : rows)
    pointers.push_back(row.data());
  png_write_image(png, pointers.data());
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return file;
}

std::string EncodeJpeg(const TestImage& image, int quality) {
  jpeg_compress_struct jpeg{};
  jpeg_error_mgr errors{};
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  unsigned char* buffer = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&jpeg, &buffer, &size);
  jpeg.image_width = static_cast<JDIMENSION>(image.width);
  jpeg.image_height = static_cast<JDIMENSION>(image.height);
  jpeg.input_components = image.channels;
  jpeg.in_color_space = image.channels == 1 ? JCS_GRAYSCALE : JCS_RGB;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, quality, TRUE);
  jpeg_start_compress(&jpeg, TRUE);
  for (int y = 0; y < image.height; ++y) {
    std::vector<std::uint8_t> row = PngRow(image, y, 8);
    JSAMPROW pointer = row.data();
    jpeg_write_scanlines(&jpeg, &pointer, 1);
  }
  jpeg_finish_compress(&jpeg);
  jpeg_destroy_compress(&jpeg);
  const std::unique_ptr<unsigned char, decltype(&std::free)> owner(buffer, &std::free);
  return {reinterpret_cast<char*>(buffer), size};
}

std::string EncodeWebpLossless(const TestImage& image) {
  std::vector<std::uint8_t> rgb(image.samples.begin(), image.samples.end());
  std::uint8_t* buffer = nullptr;
  const std::size_t size =
      WebPEncodeLosslessRGB(rgb.data(), image.width, image.height, 3 * image.width, &buffer);
  const std::string file(reinterpret_cast<char*>(buffer), size);
  WebPFree(buffer);
  return file;
}

}  // namespace facet
