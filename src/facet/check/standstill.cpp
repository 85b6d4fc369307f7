// SPDX-License-Identifier: BSD-2-Clause
// Whether anything moves, by the IMU and by the images.
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "facet/check/detectors.h"

namespace facet {
namespace {

constexpr double kWindow_s = 0.5;
// 1-sigma within a window: more than any sensor's noise, less than a hand that holds still.
constexpr double kStillGyro = 0.03, kStillAccel = 0.25;
// Mean change of the small image, in grey values, less a change of the whole image's brightness.
constexpr double kStillImage = 2.5;
constexpr double kStillShare = 0.8;
constexpr int kReduced = 8;
constexpr int kMinWindows = 4;

/// Mean and squares of one sensor.
struct Scatter {
  Vector3d sum = Vector3d::Zero();
  double squares = 0;
  int num = 0;

  void Add(const Vector3d& x) {
    sum += x;
    squares += x.squaredNorm();
    ++num;
  }
  double sigma() const {
    return num == 0 ? 0 : std::sqrt(std::max(0.0, squares / num - (sum / num).squaredNorm()));
  }
};

class Standstill : public Detector {
 public:
  void OnImu(const ImuSample& sample) override {
    gyro_.Add(sample.gyro);
    accel_.Add(sample.accel);
  }

  void OnImages(const ImagePair& pair) override {
    if (!pair.follows || !begin_) return Begin(pair);
    if (ToSeconds(pair.t - *begin_) < kWindow_s - 0.001) return;
    cv::Mat difference;
    const cv::Mat now = Reduced(pair.left);
    cv::absdiff(now, small_, difference);
    const bool is_image_still =
        now.size() == small_.size() && cv::mean(difference)[0] < kStillImage;
    const bool is_imu_still =
        gyro_.num > 2 && gyro_.sigma() < kStillGyro && accel_.sigma() < kStillAccel;
    ++num_windows_;
    num_still_ += is_image_still && is_imu_still ? 1 : 0;
    Begin(pair);
  }

  void Finish(CheckReport& report) override {
    if (num_windows_ < kMinWindows) {
      report.unchecked.push_back({"standing_still", "too few images in a row"});
      return;
    }
    const double share = static_cast<double>(num_still_) / num_windows_;
    if (share < kStillShare) return;
    report.Add({"standing_still",
                Sureness::kCertain,
                Text("for %.0f %% of the time nothing moves, neither for the IMU nor in the images",
                     100 * share),
                "move, in all directions and about all axes; is this the right recording?"});
  }

 private:
  /// Small, with a mean of zero.
  static cv::Mat Reduced(const cv::Mat& image) {
    cv::Mat small, signed_small;
    const cv::Size size(std::max(1, image.cols / kReduced), std::max(1, image.rows / kReduced));
    cv::resize(image, small, size, 0, 0, cv::INTER_AREA);
    small.convertTo(signed_small, CV_32F, 1, -cv::mean(small)[0]);
    return signed_small;
  }

  void Begin(const ImagePair& pair) {
    begin_ = pair.t;
    small_ = Reduced(pair.left);
    gyro_ = accel_ = Scatter();
  }

  std::optional<Timestamp> begin_;
  cv::Mat small_;
  Scatter gyro_, accel_;
  int num_windows_ = 0, num_still_ = 0;
};

}  // namespace

std::unique_ptr<Detector> MakeStandstill() {
  return std::make_unique<Standstill>();
}

}  // namespace facet
