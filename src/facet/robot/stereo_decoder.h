// SPDX-License-Identifier: BSD-2-Clause
// Pairs of received images to grey ones of the calibrated size.
#pragma once

#include <string>
#include <vector>

#include "facet/facet.h"
#include "facet/robot/image_pairer.h"

namespace facet {
namespace robot {

/// An image without pixels is one that is missing or cannot be used.
struct GreyPair {
  api::Image left, right;
  std::vector<std::string> problems;  ///< one for each image that came and cannot be used
};

/// Not thread-safe.
class StereoDecoder {
 public:
  /// Throws api::Error where `sample_bits` cannot be.
  explicit StereoDecoder(int sample_bits) : decoder_(sample_bits) {}

  /// As `facet run`: without a left image there is no frame, and the right one is not looked at.
  GreyPair Decode(const ImagePair& pair, const api::Calibration& calibration);

 private:
  api::Image DecodeOne(const ReceivedImage& image,
                       const api::Camera& camera,
                       const std::string& name,
                       std::vector<std::string>& problems);

  api::ImageDecoder decoder_;
};

}  // namespace robot
}  // namespace facet
