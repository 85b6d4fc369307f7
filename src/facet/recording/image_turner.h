// SPDX-License-Identifier: BSD-2-Clause
// Right images that were taken a few milliseconds before or after the left ones.
#pragma once

#include <deque>
#include <vector>

#include <opencv2/core.hpp>

#include "facet/camera/camera_model.h"
#include "facet/imu/imu_types.h"

namespace facet {

/// Turns an image to what the camera would have seen if it had looked elsewhere. Not
/// thread-safe.
class ImageTurner {
 public:
  explicit ImageTurner(const CameraModel& camera) : camera_(camera) {}

  /// `image` (8-bit grey, of the camera's size, CHECKed) becomes what the camera would have seen in
  /// another orientation: `R_image_wanted` maps rays from there to the camera that took the image.
  /// Bilinear; what the image does not show becomes black.
  void Turn(const Matrix3d& R_image_wanted, cv::Mat& image);

 private:
  void FindRays();

  CameraModel camera_;
  cv::Mat rays_;  ///< bearing of one pixel in the middle of each cell; NaN: there is none
  cv::Mat shifts_, map_, turned_;
};

/// From the body at `to` to the body at `from`, both stamps of the IMU's clock, by the rates in
/// between; before the first sample the rate is that of the first one, behind the last one that of
/// the last. Samples
/// are in order; without any the body rests. The biases of the rates stay in: over 10 ms they do
/// not matter.
Quaterniond RotationBetween(const std::deque<ImuSample>& samples, Timestamp from, Timestamp to);

}  // namespace facet
