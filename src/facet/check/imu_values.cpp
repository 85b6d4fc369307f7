// SPDX-License-Identifier: BSD-2-Clause
// Samples that cannot be what the body did (the screen of the estimator counts them), samples at
// the end of the range, and axes that measure nothing.
#include <algorithm>
#include <deque>

#include "facet/check/detectors.h"
#include "facet/imu/imu_screen.h"
#include "facet/plausibility/dead_axis_check.h"

namespace facet {
namespace {

// Of a sensor with coarse digits, a few samples may be the largest by chance.
constexpr double kSaturatedShare = 0.004, kFewSaturated = 8;
constexpr double kFrozen_s = 0.15;
constexpr std::size_t kKept = 4;

/// Samples of a sensor at the largest value that it has had: peaks are each at their own, the end
/// of a range is the same for all axes.
class RangeEnd {
 public:
  /// No sensor ends below `least`.
  explicit RangeEnd(double least) : least_(least) {}

  void Add(const Vector3d& x, Timestamp t) {
    const double size = x.cwiseAbs().maxCoeff();
    if (size < std::max(least_, largest_)) return;
    if (size > largest_) {
      largest_ = size;
      num_ = 0;
      when_.from = t;
    }
    ++num_;
    when_.to = t;
  }

  double largest() const { return largest_; }
  int num() const { return num_; }
  const Span& when() const { return when_; }

 private:
  double least_, largest_ = 0;
  int num_ = 0;
  Span when_;
};

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
    gyro_end_.Add(sample.gyro, sample.t);
    accel_end_.Add(sample.accel, sample.t);
    repeated_.Follow(screen_.counts().num_repeated, sample.t);
    dead_axes_.Add(sample);
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
    for (const DeadAxis& dead : dead_axes_.found()) {
      report.Add({"imu_dead_axis",
                  Sureness::kCertain,
                  InWords(dead),
                  kDeadAxisAdvice,
                  Span{dead.from, dead.to}});
    }
    FinishRange("gyroscope", "rad/s", gyro_end_, report);
    FinishRange("accelerometer", "m/s^2", accel_end_, report);
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
  void FinishRange(const char* sensor,
                   const char* unit,
                   const RangeEnd& end,
                   CheckReport& report) const {
    if (end.num() < std::max(kFewSaturated, kSaturatedShare * num_)) return;
    report.Add({"imu_saturated",
                Sureness::kLikely,
                Text("%.1f %% of the samples of the %s are exactly at %.3g %s and none is beyond: "
                     "its range ends there",
                     100.0 * end.num() / num_,
                     sensor,
                     end.largest(),
                     unit),
                "set a larger range of the IMU, and mount it more softly if it is vibration",
                end.when()});
  }

  ImuScreen screen_;
  std::deque<ImuSample> believed_;
  std::optional<Timestamp> first_;
  Timestamp last_;
  int num_ = 0;
  Rise cut_, repeated_;
  DeadAxisCheck dead_axes_;
  RangeEnd gyro_end_{0.3}, accel_end_{12.0};
};

}  // namespace

std::unique_ptr<Detector> MakeImuValues() {
  return std::make_unique<ImuValues>();
}

}  // namespace facet
