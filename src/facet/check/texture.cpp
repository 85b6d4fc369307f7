// SPDX-License-Identifier: BSD-2-Clause
// Whether there are corners to follow.
#include "facet/check/detectors.h"
#include "facet/frontend/feature_detector.h"
#include "facet/frontend/image_pyramid.h"

namespace facet {
namespace {

constexpr double kBetween_s = 0.24;
// An image with fewer corners does not carry an estimate; more than this share of them is too much.
constexpr std::size_t kFewCorners = 20;
constexpr double kShare = 0.4;
constexpr int kMinImages = 5;

class Texture : public Detector {
 public:
  void OnImages(const ImagePair& pair) override {
    if (last_ && ToSeconds(pair.t - *last_) < kBetween_s) return;
    last_ = pair.t;
    pyramid_.Build(pair.left, options_.klt.num_levels);
    const std::size_t num =
        detector_.Detect(pair.left, pyramid_.level(0), {}, options_.max_features).size();
    ++num_;
    corners_.push_back(static_cast<double>(num));
    if (num >= kFewCorners) return;
    if (num_few_++ == 0) when_.from = pair.t;
    when_.to = pair.t;
  }

  void Finish(CheckReport& report) override {
    report.measured.push_back(Text("%.0f corners in an image (median, at most %d)",
                                   MedianOf(corners_),
                                   options_.max_features));
    if (num_ < kMinImages || num_few_ < kShare * num_) return;
    report.Add({"no_texture",
                Sureness::kCertain,
                Text("%.0f %% of the left images have fewer than %zu corners that can be followed "
                     "(median %.0f)",
                     100.0 * num_few_ / num_,
                     kFewCorners,
                     MedianOf(corners_)),
                "look at things with texture, with more light; bare walls and the sky cannot be "
                "used",
                when_});
  }

 private:
  FrontendOptions options_;
  FeatureDetector detector_{options_.detector, options_.klt};
  ImagePyramid pyramid_;
  std::optional<Timestamp> last_;
  int num_ = 0, num_few_ = 0;
  std::vector<double> corners_;
  Span when_;
};

}  // namespace

std::unique_ptr<Detector> MakeTexture() {
  return std::make_unique<Texture>();
}

}  // namespace facet
