// SPDX-License-Identifier: BSD-2-Clause
#include "facet/recording/frame_decoder.h"

#include "facet/base/stage_timer.h"
#include "facet/io/errors.h"

namespace facet {

FrameDecoder::FrameDecoder(const StereoRig& rig) {
  for (std::size_t i = 0; i < 2; ++i)
    sizes_[i] = cv::Size(rig.cameras[i].width(), rig.cameras[i].height());
}

void FrameDecoder::DecodeImage(int camera, const EncodedImage& source, cv::Mat& image) {
  const cv::Size& wanted = sizes_[camera];
  const cv::Size size = source.Decode(wanted, reader_, image);
  if (size == wanted) return;
  throw InputError(source.Place() + ": the image has " + std::to_string(size.width) + " x " +
                   std::to_string(size.height) + " pixels, the calibration of cam" +
                   std::to_string(camera) + " has " + std::to_string(wanted.width) + " x " +
                   std::to_string(wanted.height) + "; scale the one or recalibrate the other");
}

std::string FrameDecoder::Decode(const RecordedFrame& frame, cv::Mat& left, cv::Mat& right) {
  DecodeImage(0, *frame.left, left);
  if (!frame.HasRight()) {
    right.release();
    return {};
  }
  try {
    DecodeImage(1, *frame.right, right);
  } catch (const InputError& error) {
    right.release();
    return error.what();
  }
  return {};
}

void FrameDecoder::Decode(const RecordedFrame& frame, DecodedFrame& decoded) {
  const double start_ms = ThreadCpuMs();
  decoded.left_problem.clear();
  decoded.right_problem.clear();
  try {
    decoded.right_problem = Decode(frame, decoded.left, decoded.right);
  } catch (const InputError& error) {
    decoded.left_problem = error.what();
  }
  decoded.cpu_ms = ThreadCpuMs() - start_ms;
}

}  // namespace facet
