// SPDX-License-Identifier: BSD-2-Clause
// The size of gravity: units and scale of the accelerometer.
#include <cmath>

#include "facet/check/detectors.h"
#include "facet/geometry/so3.h"

namespace facet {
namespace {

// Over such a time the mean force is gravity but for the change of velocity.
constexpr double kWindow_s = 2;
constexpr double kHole_s = 0.1;
constexpr std::size_t kMinWindows = 3, kMostWindows = 20000;
constexpr double kScale = 0.07;
// Far less: gravity is missing, or the unit is another one.
constexpr double kMissing = 0.3 * kGravity;
constexpr double kLeastInG = 0.8, kMostInG = 1.25, kSteady = 0.7;

class SpecificForce : public Detector {
 public:
  void OnImu(const ImuSample& sample) override {
    if (last_) {
      const double dt_s = ToSeconds(sample.t - last_->t);
      if (dt_s > kHole_s) {
        Begin();
      } else {
        R_ = R_ * ExpSO3(0.5 * dt_s * (last_->gyro + sample.gyro));
        sum_ += dt_s * (R_ * sample.accel);
        sum_of_sizes_ += dt_s * sample.accel.norm();
        duration_s_ += dt_s;
      }
    }
    last_ = sample;
    if (duration_s_ < kWindow_s) return;
    if (means_.size() < kMostWindows) {
      means_.push_back(sum_.norm() / duration_s_);
      sizes_.push_back(sum_of_sizes_ / duration_s_);
    }
    Begin();
  }

  void Finish(CheckReport& report) override {
    if (means_.size() < kMinWindows) {
      report.unchecked.push_back({"accel_scale", "the IMU is too short"});
      return;
    }
    // Turned together, the forces add up to gravity; a wrong gyroscope makes their sum smaller.
    const double size = MedianOf(sizes_);
    const double mean = report.is_gyroscope_wrong ? size : MedianOf(means_);
    report.measured.push_back(
        Text("mean force turned back by the gyroscope %.2f m/s^2, its mean size %.2f", mean, size));
    if (size < kMissing) return FinishSmall(mean, size, report);
    const bool is_high = mean > (1 + kScale) * kGravity;
    const bool is_low = mean < (1 - kScale) * kGravity && size < kGravity;
    if (mean < kMissing) {
      AddNoGravity(mean, report);
    } else if (is_high || is_low) {
      report.Add(
          {"accel_scale",
           Sureness::kLikely,
           Text("on average the accelerometer measures %.2f m/s^2 where gravity is 9.81", mean),
           "check units and range of the accelerometer; its values are m/s^2"});
    }
  }

 private:
  void Begin() {
    R_ = Quaterniond::Identity();
    sum_.setZero();
    sum_of_sizes_ = duration_s_ = 0;
  }

  static void AddNoGravity(double mean, CheckReport& report) {
    report.Add({"no_gravity",
                Sureness::kCertain,
                Text("there is no gravity in the accelerations: their mean is %.2f m/s^2", mean),
                "record the raw acceleration instead of the one without gravity (\"linear "
                "acceleration\")"});
  }

  static void FinishSmall(double mean, double size, CheckReport& report) {
    if (mean < kSteady * size || mean < kLeastInG || mean > kMostInG)
      return AddNoGravity(mean, report);
    report.Add({"accel_scale",
                Sureness::kCertain,
                Text("on average the accelerometer measures %.3f where gravity is 9.81 m/s^2: it "
                     "is in g",
                     mean),
                "multiply the accelerations by 9.81"});
  }

  std::optional<ImuSample> last_;
  Quaterniond R_ = Quaterniond::Identity();
  Vector3d sum_ = Vector3d::Zero();
  double sum_of_sizes_ = 0, duration_s_ = 0;
  std::vector<double> means_, sizes_;
};

}  // namespace

std::unique_ptr<Detector> MakeSpecificForce() {
  return std::make_unique<SpecificForce>();
}

}  // namespace facet
