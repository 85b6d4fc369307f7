// SPDX-License-Identifier: BSD-2-Clause
// The left camera sends the same image again although it moves.
#include "facet/check/detectors.h"
#include "facet/frontend/repeated_image.h"

namespace facet {
namespace {

// Mean rate of the gyroscope, above any usual bias [rad/s].
constexpr double kMoves = 0.1;
// Images that differ before and behind so few repetitions show that they should differ, too.
constexpr int kFew = 3;
constexpr double kShare = 0.03;

class RepeatedImages : public Detector {
 public:
  void OnImu(const ImuSample& sample) override {
    rates_ += sample.gyro.norm();
    ++num_rates_;
  }

  void OnImages(const ImagePair& pair) override {
    ++num_;
    const bool is_same = pair.follows && AreSameImage(pair.left, last_);
    if (is_same) {
      ++run_;
      num_turning_ += num_rates_ > 0 && rates_ / num_rates_ > kMoves ? 1 : 0;
      if (run_ == 1) begin_ = pair.t;
    } else {
      EndRun(pair.t);
    }
    last_ = pair.left.clone();
    rates_ = 0;
    num_rates_ = 0;
  }

  void Finish(CheckReport& report) override {
    EndRun(begin_);
    if (num_repeated_ <= kShare * num_) return;
    report.Add({"images_repeated",
                Sureness::kCertain,
                Text("%d of %d left images repeat the one before pixel by pixel although the "
                     "camera moves",
                     num_repeated_,
                     num_),
                "look for a driver or a recorder that fills a missing image with the last one",
                when_});
  }

 private:
  void EndRun(Timestamp t) {
    if (run_ == 0) return;
    const int num = run_ <= kFew ? run_ : num_turning_;
    if (num > 0) {
      if (num_repeated_ == 0) when_.from = begin_;
      when_.to = t;
    }
    num_repeated_ += num;
    run_ = num_turning_ = 0;
  }

  cv::Mat last_;
  double rates_ = 0;
  int num_rates_ = 0, num_ = 0, num_repeated_ = 0;
  int run_ = 0, num_turning_ = 0;  // of the newest repetitions
  Timestamp begin_;
  Span when_;
};

}  // namespace

std::unique_ptr<Detector> MakeRepeatedImages() {
  return std::make_unique<RepeatedImages>();
}

}  // namespace facet
