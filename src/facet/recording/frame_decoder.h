// SPDX-License-Identifier: BSD-2-Clause
// From the frames of a recording to images of the calibrated size.
#pragma once

#include <optional>
#include <string>

#include "facet/camera/stereo_rig.h"
#include "facet/recording/recording.h"

namespace facet {

struct DecodedFrame {
  cv::Mat left, right;        ///< `right` is empty where there is none, or an unusable one
  std::string left_problem;   ///< why the left image, and with it the frame, is unusable; or empty
  std::string right_problem;  ///< why the right one is, or empty
  double cpu_ms = 0;          ///< that decoding took
};

/// Decodes one frame after the other and keeps its buffers. Not thread-safe.
class FrameDecoder {
 public:
  explicit FrameDecoder(const StereoRig& rig);

  /// Decodes into 8-bit grey images of the calibrated size. Throws InputError when the left image
  /// is unusable. An unusable or absent right image leaves `right` empty; the returned text says
  /// what is wrong with it and is empty when it is fine or not in the recording.
  std::string Decode(const RecordedFrame& frame, cv::Mat& left, cv::Mat& right);

  /// The same without a throw for an unusable left image.
  void Decode(const RecordedFrame& frame, DecodedFrame& decoded);

 private:
  void DecodeImage(int camera, const EncodedImage& source, cv::Mat& image);

  cv::Size sizes_[2];
  ImageReader reader_;
};

}  // namespace facet
