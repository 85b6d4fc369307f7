// SPDX-License-Identifier: BSD-2-Clause
#include "facet/loop/upright_corners.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <numbers>

#include <opencv2/imgproc.hpp>

#include "facet/base/check.h"

namespace facet {

namespace {

constexpr int kPatch_px = 31;       // of a descriptor, on its level
constexpr int kBorder_px = 24;      // in the full image
constexpr int kCell_px = 14;        // on the level: at most one corner each
constexpr int kFastThreshold = 10;  // grey values

double LevelScale(int level) {
  return std::pow(kCornerLevelScale, level);
}

}  // namespace

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
__attribute__((target_clones("popcnt", "default")))
#endif
int HammingDistance(const BinaryDescriptor& a, const BinaryDescriptor& b) {
  return std::popcount(a[0] ^ b[0]) + std::popcount(a[1] ^ b[1]) + std::popcount(a[2] ^ b[2]) +
         std::popcount(a[3] ^ b[3]);
}

UprightCorners::UprightCorners(const CameraModel& camera)
    : camera_(camera),
      orb_(cv::ORB::create(1,
                           static_cast<float>(kCornerLevelScale),
                           kNumCornerLevels,
                           kBorder_px,
                           0,
                           2,
                           cv::ORB::FAST_SCORE,
                           kPatch_px)) {}

std::vector<UprightCorner> UprightCorners::Detect(const cv::Mat& image, const Vector3d& up_C) {
  FACET_CHECK(image.type() == CV_8UC1);
  keypoints_.clear();
  for (int level = 0; level < kNumCornerLevels; ++level)
    DetectLevel(image, level);
  TurnUpright(up_C);
  return DescribeKeypoints(image);
}

std::vector<UprightCorner> UprightCorners::Describe(const cv::Mat& image,
                                                    const Vector3d& up_C,
                                                    std::span<const Vector2d> places) {
  FACET_CHECK(image.type() == CV_8UC1);
  keypoints_.clear();
  for (int level = 0; level < kNumCornerLevels; ++level) {
    for (std::size_t i = 0; i < places.size(); ++i) {
      cv::KeyPoint keypoint(
          cv::Point2f(static_cast<float>(places[i].x()), static_cast<float>(places[i].y())),
          static_cast<float>(kPatch_px * LevelScale(level)));
      keypoint.octave = level;
      keypoint.class_id = static_cast<int>(i);
      keypoints_.push_back(keypoint);
    }
  }
  TurnUpright(up_C);
  return DescribeKeypoints(image);
}

void UprightCorners::DetectLevel(const cv::Mat& image, int level) {
  const double scale = LevelScale(level);
  const cv::Mat* source = &image;
  if (level > 0) {
    cv::resize(image, scaled_, {}, 1 / scale, 1 / scale, cv::INTER_AREA);
    source = &scaled_;
  }
  cv::FAST(*source, level_corners_, kFastThreshold, true);
  const int columns = source->cols / kCell_px + 1, rows = source->rows / kCell_px + 1;
  best_.assign(static_cast<std::size_t>(columns * rows), -1);
  for (std::size_t i = 0; i < level_corners_.size(); ++i) {
    const cv::Point2f& p = level_corners_[i].pt;
    int& best = best_[static_cast<std::size_t>(static_cast<int>(p.y) / kCell_px * columns +
                                               static_cast<int>(p.x) / kCell_px)];
    if (best < 0 || level_corners_[i].response > level_corners_[best].response)
      best = static_cast<int>(i);
  }
  for (const int i : best_) {
    if (i < 0) continue;
    cv::KeyPoint keypoint = level_corners_[i];
    // The centre of a pixel of the small image in the full one.
    keypoint.pt.x = static_cast<float>((keypoint.pt.x + 0.5) * scale - 0.5);
    keypoint.pt.y = static_cast<float>((keypoint.pt.y + 0.5) * scale - 0.5);
    keypoint.octave = level;
    keypoint.size = static_cast<float>(kPatch_px * scale);
    keypoints_.push_back(keypoint);
  }
}

// The direction in which the image of a point moves when the point is lifted.
void UprightCorners::TurnUpright(const Vector3d& up_C) {
  constexpr double kLift = 1e-3;
  std::erase_if(keypoints_, [&](cv::KeyPoint& keypoint) {
    const Vector2d px(keypoint.pt.x, keypoint.pt.y);
    const auto bearing = camera_.Unproject(px);
    if (!bearing) return true;
    const auto lifted = camera_.Project(*bearing + kLift * up_C);
    const auto itself = camera_.Project(*bearing);
    if (!lifted || !itself) return true;
    const Vector2d up_px = *lifted - *itself;
    keypoint.angle = static_cast<float>(std::atan2(up_px.y(), up_px.x()) * 180 / std::numbers::pi);
    if (keypoint.angle < 0) keypoint.angle += 360;
    return false;
  });
}

std::vector<UprightCorner> UprightCorners::DescribeKeypoints(const cv::Mat& image) {
  orb_->compute(image, keypoints_, descriptors_);
  std::vector<UprightCorner> corners(keypoints_.size());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    UprightCorner& corner = corners[i];
    corner.px = {keypoints_[i].pt.x, keypoints_[i].pt.y};
    corner.level = keypoints_[i].octave;
    corner.source = keypoints_[i].class_id;
    std::memcpy(
        corner.descriptor.data(), descriptors_.ptr(static_cast<int>(i)), sizeof(BinaryDescriptor));
  }
  return corners;
}

}  // namespace facet
