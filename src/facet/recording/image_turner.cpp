// SPDX-License-Identifier: BSD-2-Clause
#include "facet/recording/image_turner.h"

#include <algorithm>
#include <limits>

#include <opencv2/imgproc.hpp>

#include "facet/base/check.h"
#include "facet/geometry/so3.h"

namespace facet {
namespace {

// Over so many pixels the shift of a pixel is linear, to a hundredth of a pixel.
constexpr int kCell = 8;
constexpr double kMiddle = 0.5 * (kCell - 1);

}  // namespace

void ImageTurner::FindRays() {
  rays_.create(
      (camera_.height() + kCell - 1) / kCell, (camera_.width() + kCell - 1) / kCell, CV_32FC3);
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  for (int y = 0; y < rays_.rows; ++y) {
    for (int x = 0; x < rays_.cols; ++x) {
      const auto ray = camera_.Unproject(Vector2d(kCell * x + kMiddle, kCell * y + kMiddle));
      rays_.at<cv::Vec3f>(y, x) = ray ? cv::Vec3f(static_cast<float>(ray->x()),
                                                  static_cast<float>(ray->y()),
                                                  static_cast<float>(ray->z()))
                                      : cv::Vec3f(kNone, kNone, kNone);
    }
  }
}

void ImageTurner::Turn(const Matrix3d& R_image_wanted, cv::Mat& image) {
  FACET_CHECK(image.type() == CV_8UC1 && image.cols == camera_.width() &&
              image.rows == camera_.height())
      << "the image is not of the camera";
  if (rays_.empty()) FindRays();
  constexpr float kOutside = -1e5F;
  shifts_.create(rays_.size(), CV_32FC2);
  for (int y = 0; y < rays_.rows; ++y) {
    const cv::Vec3f* rays = rays_.ptr<cv::Vec3f>(y);
    for (int x = 0; x < rays_.cols; ++x) {
      const Vector3d ray(rays[x][0], rays[x][1], rays[x][2]);
      const auto px = ray.allFinite() ? camera_.Project(R_image_wanted * ray) : std::nullopt;
      shifts_.at<cv::Vec2f>(y, x) =
          px ? cv::Vec2f(static_cast<float>(px->x() - (kCell * x + kMiddle)),
                         static_cast<float>(px->y() - (kCell * y + kMiddle)))
             : cv::Vec2f(kOutside, kOutside);
    }
  }
  cv::resize(
      shifts_, map_, cv::Size(kCell * rays_.cols, kCell * rays_.rows), 0, 0, cv::INTER_LINEAR);
  map_ = map_(cv::Rect(0, 0, image.cols, image.rows));
  for (int y = 0; y < map_.rows; ++y) {
    cv::Vec2f* map = map_.ptr<cv::Vec2f>(y);
    for (int x = 0; x < map_.cols; ++x)
      map[x] += cv::Vec2f(static_cast<float>(x), static_cast<float>(y));
  }
  cv::remap(image, turned_, map_, cv::Mat(), cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  cv::swap(image, turned_);
}

Quaterniond RotationBetween(const std::deque<ImuSample>& samples, Timestamp from, Timestamp to) {
  if (samples.empty() || from == to) return Quaterniond::Identity();
  if (to < from) return RotationBetween(samples, to, from).conjugate();
  Quaterniond R = Quaterniond::Identity();
  Timestamp t = from;
  for (std::size_t i = 0; i < samples.size() && t < to; ++i) {
    // The rate of a sample holds until the next one.
    const bool is_last = i + 1 == samples.size();
    const Timestamp end = is_last ? to : std::min(to, samples[i + 1].t);
    if (end <= t) continue;
    R = R * ExpSO3(samples[i].gyro * ToSeconds(end - t));
    t = end;
  }
  return R;
}

}  // namespace facet
