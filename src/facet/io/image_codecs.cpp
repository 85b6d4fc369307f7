// SPDX-License-Identifier: BSD-2-Clause
// libpng and libjpeg report errors by longjmp. Between setjmp and the last call of the library
// there are therefore only plain variables; C++ objects live in the caller, exceptions start after
// the jump.
#include "facet/io/image_codecs.h"

#include <algorithm>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <string>

#include <jpeglib.h>
#include <png.h>
#include <webp/decode.h>

#include "facet/io/errors.h"
#include "facet/io/sample_depth.h"

namespace facet {
namespace {

constexpr std::int64_t kMaxSide = 16384;
constexpr std::int64_t kMaxPixels = 64 << 20;
constexpr std::size_t kMaxMessage = 256;

// ------------------------------------------------------------------------------------------ PNG

struct PngSource {
  Bytes bytes;
  std::size_t position = 0;
  char message[kMaxMessage] = "";
};

void ReadPngBytes(png_structp png, png_bytep target, png_size_t count) {
  auto& source = *static_cast<PngSource*>(png_get_io_ptr(png));
  if (count > source.bytes.size() - source.position) png_error(png, "the file ends too early");
  std::memcpy(target, source.bytes.data() + source.position, count);
  source.position += count;
}

void OnPngError(png_structp png, png_const_charp message) {
  auto& source = *static_cast<PngSource*>(png_get_error_ptr(png));
  std::snprintf(source.message, kMaxMessage, "%s", message);
  png_longjmp(png, 1);
}

void OnPngWarning(png_structp /*png*/, png_const_charp /*message*/) {}

/// Asks for grey or RGB without alpha, and for 8 bits per channel unless 16 are to be kept.
void SetPngTransforms(png_structp png, png_infop info, bool keeps_depth) {
  const int type = png_get_color_type(png, info);
  const int depth = png_get_bit_depth(png, info);
  if (type == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(png);
  if (type == PNG_COLOR_TYPE_GRAY && depth < 8) png_set_expand_gray_1_2_4_to_8(png);
  if (depth == 16 && !keeps_depth) png_set_scale_16(png);
  if ((type & PNG_COLOR_MASK_ALPHA) != 0) png_set_strip_alpha(png);
  png_set_interlace_handling(png);
  png_read_update_info(png, info);
}

struct PngHeader {
  png_uint_32 width = 0, height = 0;
  int channels = 0;
  int depth = 8;  // of what comes out
};

/// The two halves of decoding are separate because memory is allocated between them, outside of the
/// reach of longjmp. Both return false after an error.
bool ReadPngHeader(png_structp png, png_infop info, bool keeps_depth, PngHeader& header) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;  // NOLINT: libpng's way of reporting errors
  png_read_info(png, info);
  SetPngTransforms(png, info, keeps_depth);
  header.width = png_get_image_width(png, info);
  header.height = png_get_image_height(png, info);
  header.channels = png_get_channels(png, info);
  header.depth = png_get_bit_depth(png, info);
  return true;
}

bool ReadPngRows(png_structp png, png_bytepp rows) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;  // NOLINT: libpng's way of reporting errors
  png_read_image(png, rows);
  png_read_end(png, nullptr);
  return true;
}

class PngDecoder {
 public:
  explicit PngDecoder(Bytes file) : source_{file} {
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, &source_, OnPngError, OnPngWarning);
    if (png_ != nullptr) info_ = png_create_info_struct(png_);
    if (info_ == nullptr) {
      png_destroy_read_struct(&png_, nullptr, nullptr);
      throw InputError("libpng could not be started");
    }
    png_set_read_fn(png_, &source_, ReadPngBytes);
  }
  PngDecoder(const PngDecoder&) = delete;
  PngDecoder& operator=(const PngDecoder&) = delete;
  ~PngDecoder() { png_destroy_read_struct(&png_, &info_, nullptr); }

  PngHeader Header(bool keeps_depth) {
    PngHeader header;
    if (!ReadPngHeader(png_, info_, keeps_depth, header)) Fail();
    return header;
  }
  void Rows(std::vector<png_bytep>& rows) {
    if (!ReadPngRows(png_, rows.data())) Fail();
  }

 private:
  [[noreturn]] void Fail() const {
    throw InputError("damaged or truncated PNG: " + std::string(source_.message));
  }
  PngSource source_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
};

// ----------------------------------------------------------------------------------------- JPEG

struct JpegErrors {
  jpeg_error_mgr manager;  // first, so that the library's pointer is a pointer to this struct
  std::jmp_buf jump;
  char message[JMSG_LENGTH_MAX];
};

void OnJpegError(j_common_ptr jpeg) {
  auto* errors = reinterpret_cast<JpegErrors*>(jpeg->err);
  errors->manager.format_message(jpeg, errors->message);
  std::longjmp(errors->jump, 1);  // NOLINT: libjpeg's way of reporting errors
}

/// Level -1 is a "warning: corrupt data", after which libjpeg would invent the missing pixels.
void OnJpegMessage(j_common_ptr jpeg, int level) {
  if (level < 0) OnJpegError(jpeg);
}

bool ReadJpegHeader(jpeg_decompress_struct& jpeg, JpegErrors& errors, Bytes file) {
  if (setjmp(errors.jump) != 0) return false;  // NOLINT: libjpeg's way of reporting errors
  jpeg_create_decompress(&jpeg);
  jpeg_mem_src(&jpeg, file.data(), file.size());
  jpeg_read_header(&jpeg, TRUE);
  jpeg.out_color_space = JCS_GRAYSCALE;
  return true;
}

bool ReadJpegRows(jpeg_decompress_struct& jpeg, JpegErrors& errors, const cv::Mat& image) {
  if (setjmp(errors.jump) != 0) return false;  // NOLINT: libjpeg's way of reporting errors
  jpeg_start_decompress(&jpeg);
  while (jpeg.output_scanline < jpeg.output_height) {
    JSAMPROW row = image.data + image.step[0] * jpeg.output_scanline;
    jpeg_read_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_decompress(&jpeg);
  return true;
}

class JpegDecoder {
 public:
  JpegDecoder() {
    jpeg_.err = jpeg_std_error(&errors_.manager);
    errors_.manager.error_exit = OnJpegError;
    errors_.manager.emit_message = OnJpegMessage;
    errors_.message[0] = '\0';
  }
  JpegDecoder(const JpegDecoder&) = delete;
  JpegDecoder& operator=(const JpegDecoder&) = delete;
  ~JpegDecoder() { jpeg_destroy_decompress(&jpeg_); }

  void Decode(Bytes file, GreyTarget& target) {
    if (!ReadJpegHeader(jpeg_, errors_, file)) Fail();
    if (!PrepareGrey(jpeg_.image_width, jpeg_.image_height, target)) return;
    if (!ReadJpegRows(jpeg_, errors_, target.image)) Fail();
  }

 private:
  [[noreturn]] void Fail() const {
    throw InputError("damaged or truncated JPEG: " + std::string(errors_.message));
  }
  jpeg_decompress_struct jpeg_{};
  JpegErrors errors_{};
};

}  // namespace

bool PrepareGrey(std::int64_t width, std::int64_t height, GreyTarget& target) {
  if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide ||
      width * height > kMaxPixels) {
    throw InputError("image size " + std::to_string(width) + " x " + std::to_string(height) +
                     " is not usable (1 to " + std::to_string(kMaxSide) + " pixels a side, " +
                     std::to_string(kMaxPixels >> 20) + " megapixels at most)");
  }
  target.found = cv::Size(static_cast<int>(width), static_cast<int>(height));
  if (!target.wanted.empty() && target.found != target.wanted) return false;
  cv::Mat& image = target.image;
  const bool is_shared = image.u != nullptr && image.u->refcount > 1;
  if (is_shared || !image.isContinuous()) image.release();
  image.create(target.found, CV_8UC1);
  return true;
}

void ColourRowToGrey(const std::uint8_t* row,
                     const PixelLayout& layout,
                     int width,
                     std::uint8_t* grey) {
  for (int x = 0; x < width; ++x, row += layout.stride) {
    const int sum = 19595 * row[layout.red] + 38470 * row[layout.green] + 7471 * row[layout.blue];
    grey[x] = static_cast<std::uint8_t>((sum + 32768) >> 16);
  }
}

namespace {

/// Big-endian, as they are in the file.
std::uint16_t SampleAt(const std::uint8_t* row, std::size_t i) {
  return static_cast<std::uint16_t>(row[2 * i] << 8 | row[2 * i + 1]);
}

}  // namespace

std::uint16_t LargestPngSample(Bytes file, std::vector<std::uint8_t>& colour) {
  PngDecoder decoder(file);
  const PngHeader header = decoder.Header(true);
  cv::Mat unused;
  GreyTarget target{unused, {1, 1}};
  PrepareGrey(header.width, header.height, target);  // refuses absurd sizes
  if (header.depth != 16) return 0;
  const std::size_t num = std::size_t{header.width} * static_cast<std::size_t>(header.channels);
  colour.resize(2 * num * header.height);
  std::vector<png_bytep> rows(header.height);
  for (png_uint_32 y = 0; y < header.height; ++y)
    rows[y] = colour.data() + 2 * num * y;
  decoder.Rows(rows);
  std::uint16_t largest = 0;
  for (std::size_t i = 0; i < num * header.height; ++i)
    largest = std::max(largest, SampleAt(colour.data(), i));
  return largest;
}

void DecodePng(Bytes file, std::vector<std::uint8_t>& colour, GreyTarget& target) {
  PngDecoder decoder(file);
  const PngHeader header = decoder.Header(target.sample_bits < 16);
  if (!PrepareGrey(header.width, header.height, target)) return;
  cv::Mat& image = target.image;
  const bool is_grey = header.channels == 1, is_deep = header.depth == 16;
  const bool is_direct = is_grey && !is_deep;
  const std::size_t num = std::size_t{header.width} * static_cast<std::size_t>(header.channels);
  const std::size_t row_bytes = is_deep ? 2 * num : num;
  if (!is_direct) colour.resize(row_bytes * header.height);
  std::vector<png_bytep> rows(header.height);
  for (png_uint_32 y = 0; y < header.height; ++y) {
    rows[y] = is_direct ? image.ptr(static_cast<int>(y)) : colour.data() + row_bytes * y;
  }
  decoder.Rows(rows);
  if (is_direct) return;
  for (int y = 0; y < image.rows; ++y) {
    std::uint8_t* row = rows[y];
    for (std::size_t i = 0; is_deep && i < num; ++i)
      row[i] = ToEightBits(SampleAt(row, i), target.sample_bits);
    if (is_grey) {
      std::copy_n(row, image.cols, image.ptr(y));
    } else {
      ColourRowToGrey(row, {header.channels, 0, 1, 2}, image.cols, image.ptr(y));
    }
  }
}

void DecodeJpeg(Bytes file, GreyTarget& target) {
  JpegDecoder().Decode(file, target);
}

void DecodeWebp(Bytes file, std::vector<std::uint8_t>& colour, GreyTarget& target) {
  WebPBitstreamFeatures features;
  const VP8StatusCode status = WebPGetFeatures(file.data(), file.size(), &features);
  if (status == VP8_STATUS_NOT_ENOUGH_DATA) throw InputError("truncated WebP");
  if (status != VP8_STATUS_OK) throw InputError("damaged WebP header");
  if (features.has_animation != 0) throw InputError("animated WebP; a single image is expected");
  if (!PrepareGrey(features.width, features.height, target)) return;
  cv::Mat& image = target.image;
  const int stride = 4 * features.width;
  colour.resize(static_cast<std::size_t>(stride) * static_cast<std::size_t>(features.height));
  if (WebPDecodeBGRAInto(file.data(), file.size(), colour.data(), colour.size(), stride) ==
      nullptr) {
    throw InputError("damaged or truncated WebP");
  }
  for (int y = 0; y < image.rows; ++y) {
    const std::uint8_t* row =
        colour.data() + static_cast<std::size_t>(stride) * static_cast<std::size_t>(y);
    ColourRowToGrey(row, {4, 2, 1, 0}, image.cols, image.ptr(y));
  }
}

}  // namespace facet
