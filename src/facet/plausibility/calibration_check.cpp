// SPDX-License-Identifier: BSD-2-Clause
#include "facet/plausibility/calibration_check.h"

#include <utility>

namespace facet {
namespace {

// A turn ends after this time, or when many of its corners are lost.
constexpr double kTurn_s = 0.2, kLeastShare = 0.6;
// Of fewer corners the rotation is nothing to go by.
constexpr double kUselessShare = 0.35;
// Whoever has not turned enough by then is left in peace: a car turns about one axis only.
constexpr int kMaxFollowed = 2000;

struct Turn {
  Vector3d angle = Vector3d::Zero();
  double duration_s = 0;
};

Turn Integrate(const std::vector<ImuSample>& samples) {
  Turn turn;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const double dt_s = ToSeconds(samples[i].t - samples[i - 1].t);
    turn.angle += 0.5 * dt_s * (samples[i - 1].gyro + samples[i].gyro);
    turn.duration_s += dt_s;
  }
  return turn;
}

}  // namespace

CalibrationCheck::CalibrationCheck(const StereoRig& rig)
    : images_(std::in_place, rig.cameras[0]), gyroscope_(rig.T_BC[0].q) {}

std::string CalibrationCheck::Add(const PyramidPair* left, const ImuInterval& imu) {
  if (is_decided_) return {};
  std::string text = specific_force_.Add(imu.samples);
  if (!text.empty()) {
    text += "; check its units (a_RS_S in m/s^2) in imu0/data.csv";
  } else {
    text = FromImages(left, imu);
  }
  is_decided_ = !text.empty() || (specific_force_.IsConvinced() &&
                                  (gyroscope_.IsConvinced() || num_followed_ > kMaxFollowed));
  return text;
}

std::string CalibrationCheck::FromImages(const PyramidPair* left, const ImuInterval& imu) {
  if (gyroscope_.IsConvinced() || num_followed_ > kMaxFollowed) {
    images_.reset();
    return {};
  }
  const Turn moved = Integrate(imu.samples);
  if (left == nullptr || imu.has_hole || moved.duration_s <= 0) {
    is_following_ = false;
    return {};
  }
  std::string text;
  const bool was_following = is_following_;
  if (is_following_) {
    const double share = images_->Follow(*left);
    ++num_followed_;
    turn_.gyro_B += moved.angle;
    turn_.duration_s += moved.duration_s;
    if (turn_.duration_s < kTurn_s - 0.01 && share > kLeastShare) return {};
    is_following_ = false;
    if (share > kUselessShare) text = EndTurn();
  }
  if (text.empty() && gyroscope_.IsOfUse(moved.angle / moved.duration_s)) {
    if (!was_following || !images_->BeginAgain()) images_->Begin(left->now);
    is_following_ = true;
    turn_ = SharedTurn();
  }
  return text;
}

std::string CalibrationCheck::EndTurn() {
  const std::optional<TwoViewRotation> rotation = images_->Estimate();
  if (!rotation) return {};
  turn_.image = *rotation;
  const std::string words = gyroscope_.Add(turn_);
  if (words.empty()) return {};
  return "the images turn as if " + words +
         "; check the IMU's units (rad/s) and axes in imu0/data.csv and T_BS in cam0/sensor.yaml, "
         "or T_cam_imu";
}

}  // namespace facet
