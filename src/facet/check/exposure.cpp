// SPDX-License-Identifier: BSD-2-Clause
// Brightness: too little, too much, unsteady, or another one in each camera.
#include <algorithm>
#include <cmath>

#include "facet/check/detectors.h"

namespace facet {
namespace {

constexpr double kDarkMean = 15, kClippedShare = 0.25, kShareOfImages = 0.3;
constexpr int kClippedGrey = 250;
constexpr double kFlicker = 0.12, kUnequal = 2.0;
constexpr std::size_t kMinImages = 10;

class Exposure : public Detector {
 public:
  void OnImages(const ImagePair& pair) override {
    const double mean = cv::mean(pair.left)[0];
    const double clipped = static_cast<double>(cv::countNonZero(pair.left >= kClippedGrey)) /
                           static_cast<double>(pair.left.total());
    ++num_;
    dark_.Count(mean < kDarkMean, pair.t);
    bright_.Count(clipped > kClippedShare, pair.t);
    means_.push_back(mean);
    clipped_.push_back(clipped);
    if (pair.follows) changes_.push_back(std::abs(mean - last_mean_) / std::max(mean, 1.0));
    last_mean_ = mean;
    if (!pair.right.empty()) {
      ratios_.push_back((mean + 1) / (cv::mean(pair.right)[0] + 1));
    }
  }

  void Finish(CheckReport& report) override {
    if (means_.size() < kMinImages) return;
    const double num = static_cast<double>(num_);
    if (dark_.num > kShareOfImages * num) {
      report.Add({"too_dark",
                  Sureness::kCertain,
                  Text("%.0f %% of the left images are nearly black (median of the mean grey "
                       "values: %.0f of 255)",
                       100 * dark_.num / num,
                       MedianOf(means_)),
                  "more light, a longer exposure or more gain; 16-bit images that use their lower "
                  "bits only look like this, too",
                  dark_.when});
    }
    if (bright_.num > kShareOfImages * num) {
      report.Add({"too_bright",
                  Sureness::kCertain,
                  Text("in %.0f %% of the left images a quarter of the pixels or more is at the "
                       "upper end (median share %.0f %%)",
                       100 * bright_.num / num,
                       100 * MedianOf(clipped_)),
                  "shorten the exposure or lower the gain",
                  bright_.when});
    }
    const double change = MedianOf(changes_);
    if (change > kFlicker) {
      report.Add(
          {"flicker",
           Sureness::kCertain,
           Text("the brightness changes by %.0f %% from image to image (median)", 100 * change),
           "expose for a multiple of 1/100 s (1/120 s) under lamps, fix exposure and gain, "
           "and leave out the images of a projector that blinks"});
    }
    const double ratio = MedianOf(ratios_);
    if (ratios_.size() >= 3 && (ratio > kUnequal || ratio < 1 / kUnequal)) {
      report.Add({"unequal_brightness",
                  Sureness::kCertain,
                  Text("the %s camera is %.1f times as bright as the %s one (median)",
                       ratio > 1 ? "left" : "right",
                       std::max(ratio, 1 / ratio),
                       ratio > 1 ? "right" : "left"),
                  "let one camera command exposure and gain of both, and clean both lenses"});
    }
  }

 private:
  struct Counted {
    int num = 0;
    Span when;

    void Count(bool is, Timestamp t) {
      if (!is) return;
      if (num++ == 0) when.from = t;
      when.to = t;
    }
  };

  int num_ = 0;
  Counted dark_, bright_;
  std::vector<double> means_, clipped_, changes_, ratios_;
  double last_mean_ = 0;
};

}  // namespace

std::unique_ptr<Detector> MakeExposure() {
  return std::make_unique<Exposure>();
}

}  // namespace facet
