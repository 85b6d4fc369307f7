// SPDX-License-Identifier: BSD-2-Clause
// Whether left images have right ones of the same stamp.
#include <cmath>

#include "facet/check/detectors.h"

namespace facet {
namespace {

constexpr double kMonoShare = 0.07, kDifference_s = 0.002;
constexpr std::size_t kMostDifferences = 20000;

class Pairing : public Detector {
 public:
  void OnFrame(const RecordedFrame& frame) override {
    ++num_;
    if (!frame.HasRight()) {
      if (num_mono_++ == 0) mono_.from = frame.t;
      mono_.to = frame.t;
    } else if (differences_s_.size() < kMostDifferences) {
      differences_s_.push_back(ToSeconds(frame.t_right - frame.t));
    }
  }

  void Finish(CheckReport& report) override {
    const double share = num_ == 0 ? 0 : static_cast<double>(num_mono_) / num_;
    if (share > kMonoShare) {
      report.Add(
          {"right_missing",
           Sureness::kCertain,
           Text("%d of %d left images (%.0f %%) have no right image", num_mono_, num_, 100 * share),
           "trigger both cameras together, and record with a larger queue",
           mono_});
    }
    const double difference_s = MedianOf(differences_s_);
    if (std::abs(difference_s) > kDifference_s) {
      report.Add(
          {"right_stamps",
           Sureness::kCertain,
           Text("right images are stamped %+.1f ms against left ones (median)", 1e3 * difference_s),
           "trigger both cameras together; if they are, stamp both images alike"});
    }
  }

 private:
  int num_ = 0, num_mono_ = 0;
  Span mono_;
  std::vector<double> differences_s_;
};

}  // namespace

std::unique_ptr<Detector> MakePairing() {
  return std::make_unique<Pairing>();
}

}  // namespace facet
