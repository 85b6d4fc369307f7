// SPDX-License-Identifier: BSD-2-Clause
// What stays in the same place of the image while the camera turns: dots of an IR projector, dirt,
// a covered part of the lens.
#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "facet/check/detectors.h"

namespace facet {
namespace {

constexpr double kBetween_s = 0.3;
// The camera must have turned by this since the image before [rad]; it hides a bias of 0.15 rad/s.
constexpr double kTurn = 0.06;
constexpr int kMinImages = 12;

// Dots: pixels that are always brighter than their surroundings.
constexpr double kSurroundings_px = 4;
constexpr double kClip = 25, kLeastDot = 9, kLeastSigmas = 5;
constexpr double kShareOfDots = 0.002;
// As many cells as this must have some: otherwise it is something else, in one place.
constexpr int kColumns = 12, kRows = 8;
constexpr double kShareOfCells = 0.4;

// A covered cell: hardly any gradient in any image, and the same brightness in all of them.
constexpr double kFlat = 2.2, kSteady = 4;
constexpr double kCoveredShare = 0.22;

class FixedView : public Detector {
 public:
  void OnImu(const ImuSample& sample) override {
    if (last_imu_) turned_ += ToSeconds(sample.t - *last_imu_) * sample.gyro;
    last_imu_ = sample.t;
  }

  void OnImages(const ImagePair& pair) override {
    if (last_ && ToSeconds(pair.t - *last_) < kBetween_s) return;
    last_ = pair.t;
    const bool has_turned = turned_.norm() > kTurn;
    turned_.setZero();
    if (!has_turned || (!sum_.empty() && pair.left.size() != sum_.size())) return;
    AddDots(pair.left);
    AddCells(pair.left);
    ++num_;
  }

  void Finish(CheckReport& report) override {
    if (num_ < kMinImages) {
      for (const char* name : {"fixed_pattern", "covered"})
        report.unchecked.push_back({name, "the camera hardly turns"});
      return;
    }
    FinishDots(report);
    FinishCells(report);
  }

 private:
  void AddDots(const cv::Mat& image) {
    cv::Mat smooth, detail;
    image.convertTo(detail, CV_32F);
    cv::GaussianBlur(detail, smooth, {0, 0}, kSurroundings_px);
    detail -= smooth;
    detail = cv::max(cv::min(detail, kClip), -kClip);
    if (sum_.empty()) {
      sum_ = cv::Mat::zeros(image.size(), CV_32F);
      squares_ = cv::Mat::zeros(image.size(), CV_32F);
    }
    sum_ += detail;
    squares_ += detail.mul(detail);
  }

  void AddCells(const cv::Mat& image) {
    cv::Mat dx, dy;
    cv::Sobel(image, dx, CV_32F, 1, 0, 3, 0.125);
    cv::Sobel(image, dy, CV_32F, 0, 1, 3, 0.125);
    const cv::Mat gradient = cv::abs(dx) + cv::abs(dy);
    for (int cell = 0; cell < kColumns * kRows; ++cell) {
      const cv::Rect area = AreaOf(cell, image.size());
      const double mean = cv::mean(image(area))[0];
      Cell& c = cells_[static_cast<std::size_t>(cell)];
      c.gradient = std::max(c.gradient, cv::mean(gradient(area))[0]);
      c.sum += mean;
      c.squares += mean * mean;
    }
  }

  static cv::Rect AreaOf(int cell, const cv::Size& size) {
    const int width = size.width / kColumns, height = size.height / kRows;
    return {cell % kColumns * width, cell / kColumns * height, width, height};
  }

  void FinishDots(CheckReport& report) const {
    const float num = static_cast<float>(num_);
    int num_dots = 0;
    std::array<int, kColumns * kRows> by_cell{};
    const int width = sum_.cols / kColumns, height = sum_.rows / kRows;
    for (int y = 0; y < kRows * height; ++y) {
      for (int x = 0; x < kColumns * width; ++x) {
        const float mean = sum_.at<float>(y, x) / num;
        if (mean < kLeastDot) continue;
        const float variance = squares_.at<float>(y, x) / num - mean * mean;
        if (mean * std::sqrt(num) < kLeastSigmas * std::sqrt(std::max(variance, 1.0F))) continue;
        ++num_dots;
        ++by_cell[static_cast<std::size_t>(y / height * kColumns + x / width)];
      }
    }
    const double share = static_cast<double>(num_dots) / static_cast<double>(sum_.total());
    const auto num_cells =
        static_cast<int>(std::ranges::count_if(by_cell, [](int n) { return n > 0; }));
    report.measured.push_back(
        Text("%.2f %% of the pixels are bright dots that stay in their places, in %.0f %% of the "
             "image's parts",
             100 * share,
             100.0 * num_cells / (kColumns * kRows)));
    if (share < kShareOfDots || num_cells < kShareOfCells * kColumns * kRows) return;
    report.Add({"fixed_pattern",
                Sureness::kCertain,
                Text("%.1f %% of the pixels are bright dots, all over the image, that stay in "
                     "their places while the camera turns",
                     100 * share),
                "switch the IR pattern projector off (RealSense: emitter_enabled 0), or clean the "
                "lens if there is none"});
  }

  void FinishCells(CheckReport& report) const {
    const auto is_covered = [&](const Cell& c) {
      const double mean = c.sum / num_;
      const double sigma = std::sqrt(std::max(0.0, c.squares / num_ - mean * mean));
      return c.gradient < kFlat && sigma < kSteady;
    };
    const double share = static_cast<double>(std::ranges::count_if(cells_, is_covered)) /
                         static_cast<double>(cells_.size());
    if (share < kCoveredShare) return;
    report.Add({"covered",
                share < 0.99 ? Sureness::kCertain : Sureness::kLikely,
                Text("%.0f %% of the left image show nothing and never change while the camera "
                     "turns",
                     100 * share),
                "free the lens; parts of the rig that are in view belong out of it"});
  }

  struct Cell {
    double gradient = 0;          // largest mean of an image
    double sum = 0, squares = 0;  // of the means of the images
  };

  std::optional<Timestamp> last_, last_imu_;
  Vector3d turned_ = Vector3d::Zero();
  int num_ = 0;
  cv::Mat sum_, squares_;  // of what stands out from its surroundings
  std::array<Cell, kColumns * kRows> cells_;
};

}  // namespace

std::unique_ptr<Detector> MakeFixedView() {
  return std::make_unique<FixedView>();
}

}  // namespace facet
