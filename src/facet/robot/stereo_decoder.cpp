// SPDX-License-Identifier: BSD-2-Clause
#include "facet/robot/stereo_decoder.h"

#include <cstddef>

namespace facet {
namespace robot {

namespace {

/// Such pixels are used where they are.
bool IsPlainGrey(const api::EncodedImage& image) {
  if (image.encoding != "mono8" && image.encoding != "8UC1") return false;
  if (image.bytes == nullptr || image.width <= 0 || image.height <= 0) return false;
  const auto width = static_cast<std::size_t>(image.width);
  const auto rows = static_cast<std::size_t>(image.height);
  return image.step_bytes >= width && image.num_bytes >= image.step_bytes * (rows - 1) + width;
}

std::string InWords(int width, int height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

}  // namespace

GreyPair StereoDecoder::Decode(const ImagePair& pair, const api::Calibration& calibration) {
  GreyPair grey;
  grey.left = DecodeOne(pair.left, calibration.left, "left image: ", grey.problems);
  if (grey.left.pixels == nullptr || !pair.right) return grey;
  grey.right = DecodeOne(*pair.right, calibration.right, "right image: ", grey.problems);
  return grey;
}

api::Image StereoDecoder::DecodeOne(const ReceivedImage& image,
                                    const api::Camera& camera,
                                    const std::string& name,
                                    std::vector<std::string>& problems) {
  const api::EncodedImage& encoded = image.image;
  try {
    api::Image grey = IsPlainGrey(encoded) ? api::Image{encoded.bytes,
                                                        encoded.width,
                                                        encoded.height,
                                                        encoded.step_bytes,
                                                        image.owner}
                                           : decoder_.Decode(encoded);
    if (grey.width == camera.width && grey.height == camera.height) return grey;
    problems.push_back(name + "it has " + InWords(grey.width, grey.height) +
                       " pixels, the calibration has " + InWords(camera.width, camera.height));
  } catch (const api::Error& error) {
    problems.push_back(name + error.what());
  }
  return {};
}

}  // namespace robot
}  // namespace facet
