// SPDX-License-Identifier: BSD-2-Clause
// Samples that cannot be what the body did: the screen of the estimator counts them.
#include <deque>

#include "facet/check/detectors.h"
#include "facet/imu/imu_screen.h"

namespace facet {
namespace {

constexpr double kSaturatedShare = 0.005, kFrozen_s = 0.15;
constexpr std::size_t kKept = 4;

/// When a counter rose.
struct Rise {
  int count = 0;
  Span when;

  void Follow(int now, Timestamp t) {
    if (now > count) {
      if (count == 0) when.from = t;
      when.to = t;
    }
    count = now;
  }
};

class ImuValues : public Detector {
 public:
  void OnImu(const ImuSample& sample) override {
    screen_.Add(sample, believed_);
    while (believed_.size() > kKept)  // it looks back at the last two
      believed_.pop_front();
    if (!first_) first_ = sample.t;
    last_ = sample.t;
    ++num_;
    cut_.Follow(screen_.counts().num_cut, sample.t);
    saturated_.Follow(screen_.counts().num_saturated, sample.t);
    repeated_.Follow(screen_.counts().num_repeated, sample.t);
  }

  void Finish(CheckReport& report) override {
    if (num_ < 2) return;
    if (cut_.count > 0) {
      report.Add({"imu_glitch",
                  Sureness::kCertain,
                  Text("%d IMU samples contradict the ones before and after them", cut_.count),
                  "look at the bus and the driver of the IMU, and at its supply",
                  cut_.when});
    }
    if (saturated_.count > kSaturatedShare * num_) {
      report.Add({"imu_saturated",
                  Sureness::kLikely,
                  Text("%.1f %% of the IMU samples are at the end of the sensor's range",
                       100.0 * saturated_.count / num_),
                  "set a larger range of the IMU, and mount it more softly if it is vibration",
                  saturated_.when});
    }
    const double interval_s = ToSeconds(last_ - *first_) / (num_ - 1);
    if (repeated_.count * interval_s > kFrozen_s) {
      report.Add({"imu_frozen",
                  Sureness::kCertain,
                  Text("for %.2f s altogether the IMU repeats its last sample",
                       repeated_.count * interval_s),
                  "look at the driver, the bus and the supply of the IMU; an IMU that is published "
                  "faster than it measures does this, too",
                  repeated_.when});
    }
  }

 private:
  ImuScreen screen_;
  std::deque<ImuSample> believed_;
  std::optional<Timestamp> first_;
  Timestamp last_;
  int num_ = 0;
  Rise cut_, saturated_, repeated_;
};

}  // namespace

std::unique_ptr<Detector> MakeImuValues() {
  return std::make_unique<ImuValues>();
}

}  // namespace facet
