// SPDX-License-Identifier: BSD-2-Clause
// Rate, gaps, losses and jitter of the IMU, and whether it is there for all images.
#include <algorithm>

#include "facet/check/detectors.h"
#include "facet/check/stamp_beat.h"

namespace facet {
namespace {

constexpr double kGap_s = 0.09, kJitter_s = 0.0007, kLeastRate_hz = 60, kMissingShare = 0.03;
// A fast IMU cannot scatter by more than its interval without a change of the order.
constexpr double kJitterShare = 0.3;
constexpr double kWithoutImu_s = 0.7;

class ImuBeat : public Detector {
 public:
  void OnImu(const ImuSample& sample) override {
    if (!first_) first_ = sample.t;
    last_ = sample.t;
    beat_.Add(sample.t);
  }

  void OnFrame(const RecordedFrame& frame) override {
    if (!first_frame_) first_frame_ = frame.t;
    last_frame_ = frame.t;
  }

  void Finish(CheckReport& report) override {
    beat_.End();
    FinishEnds(report);
    FinishBeat(report);
  }

 private:
  void FinishEnds(CheckReport& report) const {
    if (!first_frame_) return;
    const Timestamp imu_begin = first_.value_or(last_frame_), imu_end = first_ ? last_ : imu_begin;
    const double before_s = ToSeconds(imu_begin - *first_frame_);
    const double after_s = ToSeconds(last_frame_ - imu_end);
    if (std::max(before_s, after_s) < kWithoutImu_s && first_) return;
    const bool is_before = before_s >= after_s;
    report.Add({"imu_missing",
                Sureness::kCertain,
                first_ ? Text("the IMU %s %.2f s %s the images do",
                              is_before ? "begins" : "ends",
                              std::max(before_s, after_s),
                              is_before ? "after" : "before")
                       : "there is no IMU sample that can be used",
                "start the IMU before the cameras and stop it after them; are stamps of cameras "
                "and IMU of the same clock?",
                is_before ? Span{*first_frame_, imu_begin} : Span{imu_end, last_frame_}});
  }

  void FinishBeat(CheckReport& report) const {
    if (beat_.num() < 3) return;
    if (beat_.num_gaps() > 0) {
      const Span& gap = *beat_.longest_gap();
      report.Add({"imu_gap",
                  Sureness::kCertain,
                  Text("%d times there is no IMU sample for %.0f ms or more, at most for %.3f s",
                       beat_.num_gaps(),
                       1e3 * kGap_s,
                       ToSeconds(gap.to - gap.from)),
                  "record with a larger queue, and let the driver of the IMU buffer",
                  gap});
    }
    const double rate_hz = 1 / std::max(beat_.median_s(), 1e-9);
    if (rate_hz < kLeastRate_hz) {
      report.Add({"imu_slow",
                  Sureness::kCertain,
                  Text("there are only %.0f IMU samples per second", rate_hz),
                  "record at 100 Hz or more; 200 Hz are usual"});
    }
    if (beat_.missing_share() > kMissingShare) {
      report.Add({"imu_dropped",
                  Sureness::kCertain,
                  Text("%.0f %% of the IMU samples are missing, judged by their usual interval of "
                       "%.2f ms",
                       100 * beat_.missing_share(),
                       1e3 * beat_.median_s()),
                  "record with a larger queue, and let the driver of the IMU buffer"});
    }
    if (beat_.jitter_s() > std::min(kJitter_s, kJitterShare * beat_.median_s())) {
      report.Add({"imu_jitter",
                  Sureness::kCertain,
                  Text("stamps of IMU samples scatter by %.2f ms (1-sigma) around a regular beat "
                       "of %.2f ms",
                       1e3 * beat_.jitter_s(),
                       1e3 * beat_.median_s()),
                  "stamp samples in the sensor, not where a packet arrives; spread the samples of "
                  "a packet over its time"});
    }
  }

  StampBeat beat_{kGap_s};
  std::optional<Timestamp> first_, first_frame_;
  Timestamp last_, last_frame_;
};

}  // namespace

std::unique_ptr<Detector> MakeImuBeat() {
  return std::make_unique<ImuBeat>();
}

}  // namespace facet
