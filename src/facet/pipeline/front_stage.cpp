// SPDX-License-Identifier: BSD-2-Clause
#include "facet/pipeline/front_stage.h"

#include <algorithm>
#include <cstdio>
#include <optional>

#include "facet/camera/camera_model.h"
#include "facet/geometry/so3.h"
#include "facet/imu/preintegration.h"
#include "facet/pipeline/refusal.h"

namespace facet {

namespace {

// The newest image may come this much before the IMU sample that follows it.
constexpr double kMaxExtrapolation_s = 0.03;
// A stamp that is further ahead of the last frame and of the whole IMU is a damaged one, until so
// many in a row agree on it.
constexpr Duration kStrayDistance{1'000'000'000};
constexpr int kStraysToConfirm = 3;

// The samples as they would be on Earth, which is what the checks know.
ImuInterval OnEarth(ImuInterval imu, double gravity) {
  for (ImuSample& sample : imu.samples)
    sample.accel *= kGravity / gravity;
  return imu;
}

// Support points are for the mesh only.
FrontendOptions FrontendOptionsOf(const VioOptions& options) {
  FrontendOptions frontend = options.frontend;
  frontend.support.enabled = frontend.support.enabled && options.mesh.enabled;
  return frontend;
}

}  // namespace

FrontStage::FrontStage(const StereoRig& rig, const VioOptions& options)
    : time_offset_(rig.time_offset),
      max_gap_s_(options.estimator.imu.max_gap_s),
      gravity_(options.estimator.imu.gravity_mps2),
      frontend_(rig, FrontendOptionsOf(options)),
      check_calibration_(options.check_calibration),
      calibration_(rig) {}

void FrontStage::AddImu(const ImuSample& sample) {
  if (imu_.Add(sample) != ImuBuffer::AddResult::kAdded) ++num_refused_imu_;
  if (!has_previous_ && !imu_.empty()) imu_.DropBefore(imu_.last_stamp() - kLongestHistory);
}

MotionPrediction FrontStage::Predict(Timestamp t) {
  MotionPrediction prediction;
  const ScopedStage stage(prediction.times, Stage::kImu);
  prediction.is_stray = IsStray(t + time_offset_);
  if (prediction.is_stray) return prediction;
  TakeFeedback();
  imu_.TimeIsAt(t + time_offset_);
  prediction.imu = IntervalTo(t + time_offset_);
  prediction.hint = MakeHint(prediction.imu);
  return prediction;
}

TrackedFrame FrontStage::Track(const StereoFrame& frame, MotionPrediction prediction) {
  TrackedFrame tracked;
  tracked.is_stray = prediction.is_stray;
  if (tracked.is_stray) {
    tracked.frontend.observations.t = frame.t;
    return tracked;
  }
  tracked.imu = std::move(prediction.imu);
  tracked.times = prediction.times;
  tracked.used_feedback = prediction.hint.inverse_distance != nullptr;
  tracked.frontend = frontend_.Process(frame, prediction.hint, tracked.times);
  ++next_frame_;
  if (!tracked.frontend.in_order) return tracked;
  previous_t_ = frame.t + time_offset_;
  has_previous_ = true;
  tracked.warning = WatchAxes(tracked.imu);
  const std::string of_right_image = JudgeRightImage(frame.t, tracked.frontend.right);
  if (!of_right_image.empty()) tracked.warning = of_right_image;
  tracked.refusal = CheckSensors(tracked);
  ForgetOldImu();
  return tracked;
}

bool FrontStage::IsStray(Timestamp t_imu) {
  const bool is_far = !imu_.empty() && t_imu - imu_.newest_stamp() > kStrayDistance &&
                      (!has_previous_ || t_imu - previous_t_ > kStrayDistance);
  if (!is_far) {
    num_strays_ = 0;
    return false;
  }
  const bool agrees =
      t_imu - newest_stray_ <= kStrayDistance && newest_stray_ - t_imu <= kStrayDistance;
  num_strays_ = num_strays_ > 0 && agrees ? num_strays_ + 1 : 1;
  newest_stray_ = t_imu;
  return num_strays_ < kStraysToConfirm;
}

std::string FrontStage::WatchAxes(const ImuInterval& imu) {
  std::string warning;
  for (const ImuSample& sample : imu.samples) {
    if (dead_axes_.Add(sample))
      warning = InWords(dead_axes_.found().back()) + ": " + kDeadAxisAdvice;
  }
  return warning;
}

std::string FrontStage::JudgeRightImage(Timestamp t, const RightImageFindings& found) {
  if (found.turn) return FollowTurn(*found.turn);
  if (!right_contradicts_.Begins(t, found.contradiction_px.has_value())) return {};
  char text[240];
  std::snprintf(text,
                sizeof(text),
                "the right image contradicts the depths of known landmarks by %.1f px and is not "
                "used: is it of another moment than the left one, or was a camera knocked?",
                *found.contradiction_px);
  return text;
}

std::string FrontStage::FollowTurn(const StereoTurn& turn) {
  right_turn_ = (right_turn_.value_or(Quaterniond::Identity()) * ExpSO3(turn.omega)).normalized();
  return "the right camera is " + InWords(turn) +
         ", which is made from here on; fasten it and calibrate again";
}

std::string FrontStage::CheckSensors(const TrackedFrame& tracked) {
  if (!check_calibration_) return {};
  const FrontendResult& seen = tracked.frontend;
  std::optional<ImuInterval> on_earth;
  if (gravity_ != kGravity) on_earth = OnEarth(tracked.imu, gravity_);
  const ImuInterval& imu = on_earth ? *on_earth : tracked.imu;
  std::string dead = dead_imu_.Add(imu.samples, seen.observations.features);
  if (!dead.empty()) return dead;
  const bool is_usable = seen.image_ok && !seen.is_repeated && !seen.is_blank;
  const std::string wrong = calibration_.Add(is_usable ? &frontend_.left_images() : nullptr, imu);
  return wrong.empty() ? wrong : kWrongCalibration + wrong;
}

// What is still needed: the time since the feedback in use, and since the frames whose feedback may
// yet come.
void FrontStage::ForgetOldImu() {
  recent_.push_back(previous_t_);
  if (static_cast<std::int64_t>(recent_.size()) > kLag) recent_.pop_front();
  Timestamp oldest = *std::min_element(recent_.begin(), recent_.end());
  for (const Feedback& feedback : feedback_) {
    if (!feedback.is_reset) oldest = std::min(oldest, feedback.state.t);
  }
  imu_.DropBefore(oldest);
}

void FrontStage::TakeFeedback() {
  while (feedback_.size() >= 2 && IsOldEnough(feedback_[1]))
    feedback_.pop_front();
  has_feedback_ =
      !feedback_.empty() && IsOldEnough(feedback_.front()) && !feedback_.front().is_reset;
}

ImuInterval FrontStage::IntervalTo(Timestamp t_imu) const {
  if (imu_.empty()) return {};
  const Duration gap = FromSeconds(max_gap_s_), extrapolation = FromSeconds(kMaxExtrapolation_s);
  if (has_previous_) return imu_.Between(previous_t_, t_imu, gap, extrapolation);
  return imu_.Between(std::min(imu_.first_stamp(), t_imu), t_imu, gap, extrapolation);
}

FrontendHint FrontStage::MakeHint(const ImuInterval& now) {
  FrontendHint hint;
  if (!has_previous_ || imu_.empty()) return hint;
  const Duration gap = FromSeconds(max_gap_s_), extrapolation = FromSeconds(kMaxExtrapolation_s);
  const ImuMotion motion =
      IntegrateMotion(now.samples, has_feedback_ ? feedback_.front().state.bias : ImuBias());
  hint.R_prev_now = motion.dR;
  if (!feedback_.empty() && IsOldEnough(feedback_.front())) hint.rig = feedback_.front().rig;
  if (!has_feedback_) return hint;

  const Feedback& feedback = feedback_.front();
  const ImuInterval since = imu_.Between(feedback.state.t, previous_t_, gap, extrapolation);
  if (since.samples.empty()) return hint;
  const Vector3d g_W(0, 0, -gravity_);
  const ImuMotion to_previous = IntegrateMotion(since.samples, feedback.state.bias);
  const NavState previous = to_previous.From(feedback.state, g_W);
  const NavState next = motion.From(previous, g_W);
  hint.p_prev_now = previous.T_WB.q.conjugate() * (next.T_WB.p - previous.T_WB.p);

  const SE3 T_C0W = (previous.T_WB * feedback.T_BC0).Inverse();
  inverse_distance_.clear();
  for (const LandmarkEstimate& landmark : feedback.landmarks) {
    const double distance_m = (T_C0W * landmark.p_W).norm();
    if (distance_m > kMinDistance_m) inverse_distance_[landmark.id] = 1.0 / distance_m;
  }
  hint.inverse_distance = &inverse_distance_;
  hint.is_motion_known = !now.samples.empty() && !now.has_hole && !since.has_hole;
  return hint;
}

}  // namespace facet
