// SPDX-License-Identifier: BSD-2-Clause
// Rate, gaps, losses and jitter of the images, and the length of the recording.
#include "facet/check/detectors.h"
#include "facet/check/stamp_beat.h"

namespace facet {
namespace {

constexpr double kGap_s = 0.45, kJitter_s = 0.004, kLeastRate_hz = 8, kMissingShare = 0.07;
constexpr double kShortest_s = 5;

class ImageBeat : public Detector {
 public:
  void OnFrame(const RecordedFrame& frame) override {
    if (!first_) first_ = frame.t;
    last_ = frame.t;
    beat_.Add(frame.t);
  }

  void Finish(CheckReport& report) override {
    beat_.End();
    const double length_s = first_ ? ToSeconds(last_ - *first_) : 0;
    if (length_s < kShortest_s) {
      report.Add({"too_short",
                  Sureness::kCertain,
                  Text("the images last for %.1f s only", length_s),
                  "record longer; 20 s and more are usual"});
    }
    if (beat_.num_gaps() > 0) {
      const Span& gap = *beat_.longest_gap();
      report.Add({"image_gap",
                  Sureness::kCertain,
                  Text("%d times there is no image for %.1f s or more, at most for %.2f s",
                       beat_.num_gaps(),
                       kGap_s,
                       ToSeconds(gap.to - gap.from)),
                  "record to a faster disk, with a larger queue or less compression, or cut the "
                  "recording there",
                  gap});
    }
    const double rate_hz = beat_.median_s() > 0 ? 1 / beat_.median_s() : 0;
    if (beat_.num() > 2 && rate_hz < kLeastRate_hz) {
      report.Add({"images_slow",
                  Sureness::kCertain,
                  Text("there are only %.1f images per second", rate_hz),
                  "record at 10 Hz or more; 20 to 30 Hz are usual"});
    }
    if (beat_.missing_share() > kMissingShare) {
      report.Add({"images_dropped",
                  Sureness::kCertain,
                  Text("%.0f %% of the images are missing, judged by their usual interval of %.1f "
                       "ms",
                       100 * beat_.missing_share(),
                       1e3 * beat_.median_s()),
                  "record to a faster disk, with a larger queue or less compression"});
    }
    if (beat_.jitter_s() > kJitter_s) {
      report.Add({"image_jitter",
                  Sureness::kCertain,
                  Text("stamps of images scatter by %.1f ms (1-sigma) around a regular beat",
                       1e3 * beat_.jitter_s()),
                  "stamp images at the exposure, by hardware or in the driver, not where they "
                  "arrive"});
    }
  }

 private:
  StampBeat beat_{kGap_s};
  std::optional<Timestamp> first_;
  Timestamp last_;
};

}  // namespace

std::unique_ptr<Detector> MakeImageBeat() {
  return std::make_unique<ImageBeat>();
}

}  // namespace facet
