// SPDX-License-Identifier: BSD-2-Clause
// The noise densities of the calibration against what the samples show.
#include <array>
#include <cmath>
#include <deque>

#include "facet/check/detectors.h"

namespace facet {
namespace {

constexpr double kWindow_s = 0.5;
constexpr std::size_t kMostWindows = 20000, kMinWindows = 8;
// The quietest windows: vibration adds to the noise, and never takes away from it.
constexpr double kQuietest = 0.05;
// Third differences of white noise are larger by the root of 1 + 9 + 9 + 1.
constexpr double kGain2 = 20;
// The stated density may be larger than what is seen: calibrations are made careful by factors of
// five to ten, and a sensor's filter takes noise away. It may be smaller, because of vibration.
constexpr double kTooHigh = 35, kTooLow = 100;

/// What no IMU that is used for odometry has, in the sensor's unit per root of Hz.
struct Limits {
  double least, most;
};
constexpr Limits kGyroLimits{3e-6, 1.2e-2}, kAccelLimits{3e-5, 1.2e-1};

/// One sensor; all axes count alike.
class DensityMeter {
 public:
  void Add(Timestamp t, const Vector3d& x) {
    if (!last_.empty() && ToSeconds(t - last_time_) > 0.1) Restart();
    last_time_ = t;
    if (!begin_) begin_ = t;
    last_.push_back(x);
    if (last_.size() < 4) return;
    const Vector3d third = last_[3] - 3 * last_[2] + 3 * last_[1] - last_[0];
    squares_ += third.squaredNorm() / (3 * kGain2);
    ++num_;
    last_.pop_front();
    const double length_s = ToSeconds(t - *begin_);
    if (length_s < kWindow_s) return;
    const double interval_s = length_s / (num_ + 2);
    if (densities_.size() < kMostWindows)
      densities_.push_back(std::sqrt(squares_ / num_ * interval_s));
    Restart();
  }

  std::optional<double> Quietest() {
    if (densities_.size() < kMinWindows) return std::nullopt;
    return QuantileOf(densities_, kQuietest);
  }

 private:
  void Restart() {
    last_.clear();
    begin_.reset();
    squares_ = 0;
    num_ = 0;
  }

  std::deque<Vector3d> last_;
  Timestamp last_time_;
  std::optional<Timestamp> begin_;
  double squares_ = 0;
  int num_ = 0;
  std::vector<double> densities_;
};

class ImuNoiseDetector : public Detector {
 public:
  explicit ImuNoiseDetector(const ImuNoise& noise) : noise_(noise) {}

  void OnImu(const ImuSample& sample) override {
    gyro_.Add(sample.t, sample.gyro);
    accel_.Add(sample.t, sample.accel);
  }

  void Finish(CheckReport& report) override {
    Judge("gyro_density",
          "gyroscope",
          "rad/s/sqrt(Hz)",
          noise_.gyro_noise,
          gyro_.Quietest(),
          kGyroLimits,
          report);
    Judge("accel_density",
          "accelerometer",
          "m/s^2/sqrt(Hz)",
          noise_.accel_noise,
          accel_.Quietest(),
          kAccelLimits,
          report);
  }

 private:
  static void Judge(const char* name,
                    const char* sensor,
                    const char* unit,
                    double stated,
                    const std::optional<double>& seen,
                    const Limits& limits,
                    CheckReport& report) {
    if (!seen) {
      report.unchecked.push_back({name, "the IMU is too short"});
      return;
    }
    report.measured.push_back(
        Text("noise density of the %s where it is quietest: %.2g %s, the "
             "calibration says %.2g",
             sensor,
             *seen,
             unit,
             stated));
    const bool is_high = stated > kTooHigh * *seen || stated > limits.most;
    const bool is_low = stated * kTooLow < *seen || stated < limits.least;
    if (!is_high && !is_low) return;
    report.Add(
        {name,
         stated > limits.most || stated < limits.least ? Sureness::kCertain : Sureness::kLikely,
         Text("the calibration says that the noise density of the %s is %.2g %s, its "
              "samples show %.2g where they are quietest: too %s",
              sensor,
              stated,
              unit,
              *seen,
              is_high ? "much" : "little"),
         Text("give the density of the data sheet in %s; neither per sample nor in other "
              "units",
              unit)});
  }

  ImuNoise noise_;
  DensityMeter gyro_, accel_;
};

}  // namespace

std::unique_ptr<Detector> MakeImuNoise(const ImuNoise& noise) {
  return std::make_unique<ImuNoiseDetector>(noise);
}

}  // namespace facet
