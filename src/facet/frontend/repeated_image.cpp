// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/repeated_image.h"

#include <algorithm>
#include <cstring>

#include "facet/geometry/so3.h"

namespace facet {

namespace {
// Predicted motion of the image from which on it should have changed. Rotation is known well;
// translation comes from a velocity that may be a little off, and little harm is done before.
constexpr double kMaxRotation_px = 0.5;
constexpr double kMaxTranslation_px = 3.0;
// After images that all differed, the first few that do not are never needed, at rest or not.
constexpr int kNumDifferent = 5;
constexpr int kNumNotNeeded = 3;
}  // namespace

bool AreSameImage(const cv::Mat& a, const cv::Mat& b) {
  if (a.empty() || a.size() != b.size() || a.type() != b.type()) return false;
  const std::size_t row_bytes = static_cast<std::size_t>(a.cols) * a.elemSize();
  for (int row = 0; row < a.rows; ++row) {
    if (std::memcmp(a.ptr(row), b.ptr(row), row_bytes) != 0) return false;
  }
  return true;
}

bool IsBlank(const cv::Mat& image) {
  if (image.empty()) return false;
  const std::uint8_t value = *image.ptr(0);
  const std::size_t row_bytes = static_cast<std::size_t>(image.cols) * image.elemSize();
  for (int row = 0; row < image.rows; ++row) {
    const std::uint8_t* begin = image.ptr(row);
    if (!std::all_of(begin, begin + row_bytes, [=](std::uint8_t v) { return v == value; }))
      return false;
  }
  return true;
}

bool RepeatedImage::Add(const cv::Mat& image, const Motion& motion) {
  is_same_ = AreSameImage(newest_, image);
  newest_ = image;
  if (!is_same_) {
    num_different_ = num_same_ == 0 ? num_different_ + 1 : 1;
    num_same_ = 0;
    since_first_ = Motion();
    return false;
  }
  ++num_same_;
  since_first_.T_prev_now = since_first_.T_prev_now * motion.T_prev_now;
  since_first_.mean_inverse_distance = motion.mean_inverse_distance;
  since_first_.rotation_slack += motion.rotation_slack;
  return MustHaveChanged(since_first_, focal_px_) ||
         (num_different_ >= kNumDifferent && num_same_ <= kNumNotNeeded);
}

bool MustHaveChanged(const RepeatedImage::Motion& since, double focal_px) {
  const SE3& T = since.T_prev_now;
  const double rotation = LogSO3(T.q).norm() - since.rotation_slack;
  return focal_px * rotation > kMaxRotation_px ||
         focal_px * T.p.norm() * since.mean_inverse_distance > kMaxTranslation_px;
}

}  // namespace facet
