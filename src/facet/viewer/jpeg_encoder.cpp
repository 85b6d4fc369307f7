// SPDX-License-Identifier: BSD-2-Clause
#include "facet/viewer/jpeg_encoder.h"

#include <cstdio>
#include <cstdlib>
#include <stdexcept>

#include <jpeglib.h>

#include "facet/base/check.h"

namespace facet {
namespace {

// libjpeg's own handler ends the program. Nothing fails here but memory.
[[noreturn]] void ThrowJpegError(j_common_ptr) {
  throw std::runtime_error("an image could not be compressed");
}

}  // namespace

std::string EncodeJpeg(const cv::Mat& grey, int quality) {
  if (grey.empty()) return "";
  FACET_CHECK(grey.type() == CV_8UC1) << "type " << grey.type();
  jpeg_compress_struct job{};
  jpeg_error_mgr errors{};
  job.err = jpeg_std_error(&errors);
  errors.error_exit = ThrowJpegError;
  jpeg_create_compress(&job);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&job, &bytes, &size);
  job.image_width = static_cast<JDIMENSION>(grey.cols);
  job.image_height = static_cast<JDIMENSION>(grey.rows);
  job.input_components = 1;
  job.in_color_space = JCS_GRAYSCALE;
  jpeg_set_defaults(&job);
  jpeg_set_quality(&job, quality, TRUE);
  job.dct_method = JDCT_IFAST;
  jpeg_start_compress(&job, TRUE);
  for (int y = 0; y < grey.rows; ++y) {
    JSAMPROW row = const_cast<JSAMPROW>(grey.ptr<unsigned char>(y));
    jpeg_write_scanlines(&job, &row, 1);
  }
  jpeg_finish_compress(&job);
  jpeg_destroy_compress(&job);
  std::string file(reinterpret_cast<const char*>(bytes), size);
  std::free(bytes);
  return file;
}

}  // namespace facet
