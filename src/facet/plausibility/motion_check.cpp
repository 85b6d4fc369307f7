// SPDX-License-Identifier: BSD-2-Clause
#include "facet/plausibility/motion_check.h"

#include <cmath>
#include <utility>

namespace facet {
namespace {

// A calibration that changes by less than this does not change the size of the world.
constexpr double kSameSize = 0.002;

double Width(const ScaleCheck::Scale& scale) {
  return scale.high - scale.low + 2 * scale.sigma;
}

}  // namespace

void MotionCheck::DistrustAccelerometer() {
  by_images_.DistrustAccelerometer();
  by_states_.DistrustAccelerometer();
}

void MotionCheck::WorldHasChanged() {
  images_.Break();
  images_.ForgetGivenRig();
  by_images_.WorldHasChanged();
  by_states_.WorldHasChanged();
  turns_.Restart();
  has_doubted_ = has_doubted_turns_ = false;
}

void MotionCheck::SetRig(const StereoRig& rig) {
  const double baseline_m = rig.baseline_m();
  if (std::abs(baseline_m / baseline_m_ - 1) > kSameSize) {
    baseline_m_ = baseline_m;
    by_images_.WorldHasChanged();
  }
  images_.SetRig(rig);
}

void MotionCheck::AddImu(const ImuInterval& imu) {
  by_states_.AddImu(imu);
  if (by_images_.IsDone()) return;
  images_.AddImu(imu, bias_ ? bias_->b_g : Vector3d::Zero());
  by_images_.AddImu(imu);
}

ScaleCheck::Finding MotionCheck::AddKeyframe(const FrameObservations& seen, const NavState* state) {
  using enum ScaleCheck::Finding;
  if (state != nullptr) bias_ = state->bias;
  const ScaleCheck::Finding by_images = FollowImages(seen);
  const ScaleCheck::Finding by_states =
      state != nullptr ? by_states_.AddKeyframe(*state) : kNothing;
  is_by_images_ = by_images >= by_states;
  const ScaleCheck::Finding finding = is_by_images_ ? by_images : by_states;
  if (finding != kDoubt) return finding;
  return std::exchange(has_doubted_, true) ? kNothing : kDoubt;
}

ScaleCheck::Finding MotionCheck::FollowImages(const FrameObservations& seen) {
  if (!bias_ || by_images_.IsDone()) return ScaleCheck::Finding::kNothing;
  NavState by_images;
  by_images.bias = *bias_;
  by_images.T_WB = images_.AddKeyframe(seen);
  if (images_.IsAtBeginning()) by_images_.Break();
  if (images_.turn() && turns_.Add(*images_.turn())) has_doubted_turns_ = true;
  if (turns_.DoAxesAgree()) by_images_.TrustGyroscope();
  return by_images_.AddKeyframe(by_images);
}

std::optional<TurnCheck::Ratio> MotionCheck::TakeDoubtOfTurns() {
  return std::exchange(has_doubted_turns_, false) ? turns_.ratio() : std::nullopt;
}

const std::optional<ScaleCheck::Scale>& MotionCheck::scale() const {
  const auto &images = by_images_.scale(), &states = by_states_.scale();
  if (!images || !states) return images ? images : states;
  return Width(*images) < Width(*states) ? images : states;
}

}  // namespace facet
