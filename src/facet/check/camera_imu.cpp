// SPDX-License-Identifier: BSD-2-Clause
// The camera against the gyroscope: units, axes, mount, time offset, scale, bias.
#include <algorithm>
#include <cmath>
#include <deque>

#include "facet/check/camera_imu_fit.h"
#include "facet/check/detectors.h"
#include "facet/geometry/angles.h"
#include "facet/plausibility/gyroscope_check.h"
#include "facet/plausibility/image_rotation.h"

namespace facet {
namespace {

// A turn ends after this time, or when many of its corners are lost; of fewer it is nothing to go
// by.
constexpr double kTurn_s = 0.2, kLeastShare = 0.6, kUselessShare = 0.35;
constexpr std::size_t kMostTurns = 1500, kMostSamples = 400000;
// Of the gyroscope around each stretch of images.
constexpr double kAround_s = 0.6;

// The sum of the angles that must be there before anything is said [rad], and the number of turns.
constexpr double kLeastTurning = 1.0;
constexpr int kMinTurns = 15;
constexpr double kLeastSigmas = 5, kCertainSigmas = 10;
// Above this it is another mount, or another sensor, and no error of a calibration.
constexpr double kGrosslyTurned = 20 * kDegree;
constexpr double kTurned = 2 * kDegree, kOffset_s = 0.006, kScale = 0.035, kBias = 0.105;
// Where the fit does not describe the turns, its parameters mean nothing.
constexpr double kLargestCost = 6;
constexpr std::size_t kNumParts = 4;
constexpr double kJump_s = 0.015;

constexpr const char* kAdvice =
    "check units (rad/s) and axes of the IMU, and the rotation between camera and IMU: T_BS takes "
    "points from the camera to the IMU, Kalibr's T_cam_imu the other way";

Sureness SurenessOf(double sigmas) {
  return sigmas > kCertainSigmas ? Sureness::kCertain : Sureness::kLikely;
}

class CameraImu : public Detector {
 public:
  explicit CameraImu(const StereoRig& rig) : rig_(rig), images_(rig.cameras[0]) {}

  void OnImu(const ImuSample& sample) override {
    if (gyro_.size() > kMostSamples) return;
    if (last_look_ && ToSeconds(sample.t - *last_look_) <= kAround_s) {
      gyro_.Add(sample.t, sample.gyro);
      return;
    }
    before_.push_back(sample);
    while (ToSeconds(sample.t - before_.front().t) > kAround_s)
      before_.pop_front();
  }

  void OnImages(const ImagePair& pair) override {
    last_look_ = pair.t;
    for (const ImuSample& sample : before_)
      gyro_.Add(sample.t, sample.gyro);
    before_.clear();
    if (turns_.size() >= kMostTurns) return;
    pyramids_.Build(pair.left, images_.num_levels());
    if (!pair.follows || !is_following_) return Begin(pair);
    const double share = images_.Follow(pyramids_);
    if (ToSeconds(pair.t - begin_) < kTurn_s - 0.01 && share > kLeastShare) return;
    if (share > kUselessShare) {
      if (const auto rotation = images_.Estimate()) turns_.push_back({begin_, pair.t, *rotation});
    }
    Begin(pair);
  }

  void Finish(CheckReport& report) override {
    double turning = 0;
    for (const ImageTurn& turn : turns_)
      turning += turn.rotation.theta.norm();
    if (turns_.size() < static_cast<std::size_t>(kMinTurns) || turning < kLeastTurning) {
      for (const char* name : {"gyroscope", "camera_imu_rotation", "time_offset", "gyro_scale"})
        report.unchecked.push_back({name, "too few turns that the images show"});
      return;
    }
    CameraImuModel start;
    start.R_CB = rig_.T_BC[0].q.conjugate();
    start.tau_s = RoughTimeOffset(turns_, gyro_);
    const std::string words = WhatIsGrosslyWrong(start.tau_s);
    if (!words.empty()) {
      report.is_gyroscope_wrong = true;
      report.Add({"gyroscope", Sureness::kCertain, "the images turn as if " + words, kAdvice});
      return;
    }
    Judge(FitCameraImu(turns_, gyro_, start), report);
  }

 private:
  void Begin(const ImagePair& pair) {
    images_.Begin(pyramids_.now);
    begin_ = pair.t;
    is_following_ = true;
  }

  std::string WhatIsGrosslyWrong(double tau_s) const {
    GyroscopeCheck check(rig_.T_BC[0].q);
    const Duration tau = FromSeconds(tau_s);
    for (const ImageTurn& turn : turns_) {
      SharedTurn shared{turn.rotation, Vector3d::Zero(), turn.duration_s()};
      if (!gyro_.Sum(turn.begin + tau, turn.end + tau, shared.gyro_B)) continue;
      if (!check.IsOfUse(shared.gyro_B / shared.duration_s)) continue;
      const std::string words = check.Add(shared);
      if (!words.empty()) return words;
    }
    return {};
  }

  void Judge(const CameraImuFit& fit, CheckReport& report) const {
    const CameraImuModel& m = fit.model;
    report.measured.push_back(Text(
        "left camera against the gyroscope, from %d turns: mount off by %.2f deg (%.1f sigma), "
        "IMU later by %.1f ms (1-sigma %.1f), images turn by %+.1f %% more (1-sigma %.1f), "
        "bias %.3f %.3f %.3f rad/s, cost %.1f",
        fit.num_turns,
        fit.turned.norm() / kDegree,
        fit.TurnedSigmas(),
        1e3 * m.tau_s,
        1e3 * fit.Sigma(7),
        100 * (std::exp(m.log_scale) - 1),
        100 * fit.Sigma(3),
        m.bias.x(),
        m.bias.y(),
        m.bias.z(),
        fit.cost));
    if (fit.num_turns < kMinTurns || fit.cost > kLargestCost) {
      report.is_gyroscope_wrong = fit.num_turns >= kMinTurns;
      for (const char* name : {"camera_imu_rotation", "time_offset", "gyro_scale"})
        report.unchecked.push_back({name, "gyroscope and images do not agree well enough"});
      return;
    }
    if (fit.turned.norm() > kGrosslyTurned && fit.TurnedSigmas() > kLeastSigmas)
      return AddOtherMount(fit, report);
    report.gyro_bias = m.bias;
    if (fit.turned.norm() > kTurned && fit.TurnedSigmas() > kLeastSigmas) {
      const Vector3d degrees = fit.turned / kDegree;
      report.Add({"camera_imu_rotation",
                  SurenessOf(fit.TurnedSigmas()),
                  Text("the rotation between the left camera and the IMU is off by %.1f deg: by "
                       "%.1f, %.1f, %.1f deg about the IMU's x, y, z axes",
                       degrees.norm(),
                       degrees.x(),
                       degrees.y(),
                       degrees.z()),
                  "calibrate cameras and IMU together again; T_BS takes points from the camera to "
                  "the IMU, Kalibr's T_cam_imu the other way"});
    }
    JudgeTime(fit, report);
    if (std::abs(m.log_scale) > kScale && std::abs(m.log_scale) > kLeastSigmas * fit.Sigma(3)) {
      const double percent = 100 * (std::exp(m.log_scale) - 1);
      report.Add({"gyro_scale",
                  SurenessOf(std::abs(m.log_scale) / fit.Sigma(3)),
                  Text("the images turn by %.1f %% %s than the gyroscope measures",
                       std::abs(percent),
                       percent > 0 ? "more" : "less"),
                  "check the focal length (is it the calibration of this resolution?) and the "
                  "range that the gyroscope is set to"});
    }
    for (int k = 0; k < 3; ++k) {
      if (std::abs(m.bias[k]) < kBias || std::abs(m.bias[k]) < kLeastSigmas * fit.Sigma(4 + k))
        continue;
      report.Add({"gyro_bias",
                  SurenessOf(std::abs(m.bias[k]) / fit.Sigma(4 + k)),
                  Text("the gyroscope measures %.2f, %.2f, %.2f rad/s too much about its x, y, z "
                       "axes",
                       m.bias.x(),
                       m.bias.y(),
                       m.bias.z()),
                  "let the driver calibrate the gyroscope at rest before recording"});
      return;
    }
  }

  static void AddOtherMount(const CameraImuFit& fit, CheckReport& report) {
    report.is_gyroscope_wrong = true;
    report.Add({"gyroscope",
                SurenessOf(fit.TurnedSigmas()),
                Text("the images turn as if the rotation between camera and IMU were off by %.0f "
                     "deg, or as if an axis of the gyroscope were negated",
                     fit.turned.norm() / kDegree),
                kAdvice});
  }

  void JudgeTime(const CameraImuFit& fit, CheckReport& report) const {
    if (JudgeClock(fit.model, report)) return;
    const double tau_s = fit.model.tau_s;
    if (std::abs(tau_s) < kOffset_s || std::abs(tau_s) < kLeastSigmas * fit.Sigma(7)) return;
    const double whole_s = tau_s + ToSeconds(rig_.time_offset);
    report.Add({"time_offset",
                SurenessOf(std::abs(tau_s) / fit.Sigma(7)),
                Text("stamps of the IMU are %.1f ms %s than the calibration says, against those of "
                     "the images",
                     1e3 * std::abs(tau_s),
                     tau_s > 0 ? "later" : "earlier"),
                Text("write timeshift_cam_imu: %.4f (seconds) into the calibration", whole_s)});
  }

  /// The time offset of parts of the recording.
  bool JudgeClock(const CameraImuModel& model, CheckReport& report) const {
    double least = 1, most = -1, sigma_s = 0;
    Timestamp changed;
    std::optional<double> before;
    double largest_step = 0;
    for (std::size_t part = 0; part < kNumParts; ++part) {
      const std::size_t begin = part * turns_.size() / kNumParts;
      const std::size_t end = (part + 1) * turns_.size() / kNumParts;
      const std::span<const ImageTurn> turns(turns_.data() + begin, end - begin);
      const auto [tau_s, sigma] = FitTimeOffset(turns, gyro_, model);
      if (sigma > kJump_s / kLeastSigmas) continue;
      sigma_s = std::max(sigma_s, sigma);
      least = std::min(least, tau_s);
      most = std::max(most, tau_s);
      if (before && std::abs(tau_s - *before) > largest_step) {
        largest_step = std::abs(tau_s - *before);
        changed = turns.front().begin;
      }
      before = tau_s;
    }
    const double range_s = most - least;
    if (!before || range_s < kJump_s || range_s < kLeastSigmas * sigma_s) return false;
    report.Add({"clock_jump",
                Sureness::kLikely,
                Text("the time offset between camera and IMU changes by %.0f ms within the "
                     "recording, the most around %.0f s",
                     1e3 * range_s,
                     ToSeconds(changed - report.first_frame)),
                "stamp both by one clock; no synchronisation of clocks (NTP) may step while "
                "recording"});
    return true;
  }

  StereoRig rig_;
  ImageRotation images_;
  PyramidPair pyramids_;
  bool is_following_ = false;
  Timestamp begin_;
  std::optional<Timestamp> last_look_;
  std::vector<ImageTurn> turns_;
  GyroTrack gyro_;
  std::deque<ImuSample> before_;  // what may be around the next stretch
};

}  // namespace

std::unique_ptr<Detector> MakeCameraImu(const StereoRig& rig) {
  return std::make_unique<CameraImu>(rig);
}

}  // namespace facet
