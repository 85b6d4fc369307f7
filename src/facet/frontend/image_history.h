// SPDX-License-Identifier: BSD-2-Clause
// Recognises an image that has come before, although others came in between: a driver that hands
// out an old buffer again. Taken at face value it says that the camera has jumped back.
#pragma once

#include <cstdint>
#include <deque>

#include <opencv2/core.hpp>

#include "facet/frontend/repeated_image.h"

namespace facet {

/// A number that depends on every pixel (CV_8UC1); images that differ have the same one by chance
/// only, once in 2^64.
std::uint64_t Fingerprint(const cv::Mat& image);

/// The newest images of the left camera, by their fingerprints. Where an image may come again by
/// itself, because it has no noise and the camera is where it was, it is none that came before. Not
/// thread-safe.
class ImageHistory {
 public:
  explicit ImageHistory(double focal_px) : focal_px_(focal_px) {}

  /// Whether the image of this frame came before, and the camera has moved since. Call for every
  /// frame; an empty image is none that could come again.
  bool Add(const cv::Mat& image, const RepeatedImage::Motion& motion);

 private:
  static constexpr std::size_t kNumKept = 100;  // five seconds of 20 Hz, one of a fast camera

  struct Seen {
    std::uint64_t fingerprint = 0;
    RepeatedImage::Motion moved;  // from the first image to when it came first
  };

  double focal_px_;
  RepeatedImage::Motion moved_;  // since the first image
  std::deque<Seen> seen_;
};

}  // namespace facet
