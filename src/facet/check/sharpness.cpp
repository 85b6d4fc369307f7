// SPDX-License-Identifier: BSD-2-Clause
// Blurred edges, and noise of the pixels.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <opencv2/imgproc.hpp>

#include "facet/check/detectors.h"

namespace facet {
namespace {

constexpr double kBetween_s = 0.24;
// The strongest gradients of the image over those of the image reduced four times: 1 for a sharp
// edge, a quarter for one that is wider than four pixels.
constexpr double kBlurred = 0.42;
constexpr double kStrongest = 0.995;
constexpr double kWeakGradient = 6;  // of the reduced image, in grey values per pixel
// The sharpest tenth of the images: the others may be blurred by motion.
constexpr double kSharpest = 0.9;
constexpr double kNoisy = 11;
constexpr int kBlock = 32;
constexpr double kQuietBlocks = 0.1;
constexpr std::size_t kMinImages = 10;

/// The size of the gradient that only this share of the pixels is below.
double StrongGradient(const cv::Mat& image) {
  cv::Mat dx, dy, size, reduced;
  cv::Sobel(image, dx, CV_32F, 1, 0, 3, 0.125);
  cv::Sobel(image, dy, CV_32F, 0, 1, 3, 0.125);
  cv::magnitude(dx, dy, size);
  std::vector<double> values;
  for (int y = 1; y + 1 < size.rows; ++y) {
    for (int x = 1; x + 1 < size.cols; ++x)
      values.push_back(size.at<float>(y, x));
  }
  return QuantileOf(values, kStrongest);
}

/// 1-sigma of white noise by Immerkaer's operator, in the quietest blocks that are neither black
/// nor clipped; negative where there is none.
double NoiseOf(const cv::Mat& image) {
  const cv::Matx33f kernel(1, -2, 1, -2, 4, -2, 1, -2, 1);
  cv::Mat response;
  cv::filter2D(image, response, CV_32F, kernel);
  response = cv::abs(response);
  std::vector<double> sigmas;
  for (int y = 0; y + kBlock <= image.rows; y += kBlock) {
    for (int x = 0; x + kBlock <= image.cols; x += kBlock) {
      const cv::Rect block(x, y, kBlock, kBlock);
      const double mean = cv::mean(image(block))[0];
      if (mean < 20 || mean > 220) continue;
      sigmas.push_back(std::sqrt(0.5 * std::numbers::pi) / 6 * cv::mean(response(block))[0]);
    }
  }
  return sigmas.empty() ? -1 : QuantileOf(sigmas, kQuietBlocks);
}

class Sharpness : public Detector {
 public:
  void OnImages(const ImagePair& pair) override {
    if (last_ && ToSeconds(pair.t - *last_) < kBetween_s) return;
    last_ = pair.t;
    cv::Mat small;
    cv::resize(pair.left,
               small,
               {std::max(8, pair.left.cols / 4), std::max(8, pair.left.rows / 4)},
               0,
               0,
               cv::INTER_AREA);
    const double coarse = StrongGradient(small);
    if (coarse > kWeakGradient) sharpness_.push_back(StrongGradient(pair.left) / coarse);
    const double noise = NoiseOf(pair.left);
    if (noise >= 0) noises_.push_back(noise);
  }

  void Finish(CheckReport& report) override {
    const double noise = noises_.size() < kMinImages ? 0 : MedianOf(noises_);
    if (noise > kNoisy) {
      report.Add({"image_noise",
                  Sureness::kCertain,
                  Text("pixels are noisy by %.0f grey values (1-sigma)", noise),
                  "more light and less gain"});
    }
    if (sharpness_.size() < kMinImages) {
      report.unchecked.push_back({"blur", "too few images with edges"});
      return;
    }
    const double sharpest = QuantileOf(sharpness_, kSharpest);
    report.measured.push_back(
        Text("sharpness of edges %.2f, noise of pixels %.1f grey values", sharpest, noise));
    if (sharpest < kBlurred) {
      report.Add({"blur",
                  Sureness::kLikely,
                  Text("also in the sharpest images edges are blurred: their gradients are %.2f of "
                       "those in the image reduced four times, where sharp ones have 0.6 to 1.2",
                       sharpest),
                  "focus the left camera, clean its lens, and shorten the exposure if it moves "
                  "fast all the time"});
    }
  }

 private:
  std::optional<Timestamp> last_;
  std::vector<double> sharpness_, noises_;
};

}  // namespace

std::unique_ptr<Detector> MakeSharpness() {
  return std::make_unique<Sharpness>();
}

}  // namespace facet
