// SPDX-License-Identifier: BSD-2-Clause
// Recognises a camera that sends the same image again although it moves: a frozen driver, a buffer
// that was not filled. Taken at face value such images say that the camera stands still.
#pragma once

#include <opencv2/core.hpp>

#include "facet/base/types.h"
#include "facet/geometry/se3.h"

namespace facet {

/// Whether both have the same pixels. Costs next to nothing for images that differ: a sensor's
/// noise shows in the first row.
bool AreSameImage(const cv::Mat& a, const cv::Mat& b);

/// Whether all pixels have the same value. Costs next to nothing for others.
bool IsBlank(const cv::Mat& image);

/// The left camera. An image that came earlier is found by ImageHistory. At rest an image may come
/// again and again (clean or compressed images do), so it counts as repeated only if the camera has
/// moved since it first came, or if it is one of the first few after images that differed. Not
/// thread-safe. References the pixels of the newest image.
class RepeatedImage {
 public:
  /// What is known of the camera's motion since the previous frame.
  struct Motion {
    SE3 T_prev_now;
    double mean_inverse_distance = 0;  ///< of what it sees [1/m]; 0: not known
    /// Largest rotation that may be an unknown bias of the gyroscope [rad].
    double rotation_slack = 0;
  };

  explicit RepeatedImage(double focal_px) : focal_px_(focal_px) {}

  /// Whether the image of this frame is a repetition. Call for every frame that has an image.
  bool Add(const cv::Mat& image, const Motion& motion);

  /// Whether the newest image has the pixels of the one before, moved or not.
  bool is_same() const { return is_same_; }

 private:
  double focal_px_;
  cv::Mat newest_;
  bool is_same_ = false;
  int num_same_ = 0;       // images in a row that were the one before
  int num_different_ = 0;  // images in a row before those that were not
  Motion since_first_;     // since the image first came
};

/// Whether the camera has moved so far that its image cannot be the same.
bool MustHaveChanged(const RepeatedImage::Motion& since, double focal_px);

}  // namespace facet
