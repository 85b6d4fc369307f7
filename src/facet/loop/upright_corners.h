// SPDX-License-Identifier: BSD-2-Clause
// Corners of an image and binary descriptors that know where up is: the rotation about the optical
// axis is that of gravity, projected at each corner, and needs not be guessed from the grey values.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <opencv2/features2d.hpp>

#include "facet/base/types.h"
#include "facet/camera/camera_model.h"

namespace facet {

/// 256 comparisons of grey values.
using BinaryDescriptor = std::array<std::uint64_t, 4>;

/// In how many bits two descriptors differ.
int HammingDistance(const BinaryDescriptor& a, const BinaryDescriptor& b);

/// Descriptors are computed on images that are smaller by this factor from level to level.
inline constexpr int kNumCornerLevels = 3;
inline constexpr double kCornerLevelScale = 1.5;

struct UprightCorner {
  Vector2d px = Vector2d::Zero();  ///< in the full image
  int level = 0;                   ///< whose image it was described in
  int source = -1;                 ///< of Describe: which point
  BinaryDescriptor descriptor{};
};

/// Keeps its buffers; not thread-safe.
class UprightCorners {
 public:
  explicit UprightCorners(const CameraModel& camera);

  /// Corners of all levels of an 8 bit grey image of the camera's size, at most one for each cell
  /// of a grid. `up_C`: against gravity, in the camera.
  std::vector<UprightCorner> Detect(const cv::Mat& image, const Vector3d& up_C);

  /// Descriptors of given places, on every level; those near the border have none.
  std::vector<UprightCorner> Describe(const cv::Mat& image,
                                      const Vector3d& up_C,
                                      std::span<const Vector2d> places);

 private:
  void DetectLevel(const cv::Mat& image, int level);
  void TurnUpright(const Vector3d& up_C);
  std::vector<UprightCorner> DescribeKeypoints(const cv::Mat& image);

  CameraModel camera_;
  cv::Ptr<cv::ORB> orb_;
  std::vector<cv::KeyPoint> keypoints_;
  std::vector<cv::KeyPoint> level_corners_;
  std::vector<int> best_;  // by cell, index into level_corners_
  cv::Mat scaled_, descriptors_;
};

}  // namespace facet
