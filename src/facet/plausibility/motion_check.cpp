// SPDX-License-Identifier: BSD-2-Clause
#include "facet/plausibility/motion_check.h"

#include <cmath>
#include <utility>

namespace facet {
namespace {

// Orientations of the stereo pair alone drift by some tenths of a degree in so many legs, a minute.
// Gravity has to stay where it is.
constexpr int kMostLegsOfImages = 300;
// A calibration that changes by less than this does not change the size of the world.
constexpr double kSameSize = 0.005;
// And by more than this it may make good a size that was wrong beyond hope.
constexpr double kLargeChange = 0.05;
// When the calibration changes, the estimator's poses follow over some keyframes.
constexpr Duration kStatesSettle{1'000'000'000};

// Distances are this over the disparity.
double SizeOf(const StereoRig& rig) {
  return rig.baseline_m() *
         std::sqrt(rig.cameras[0].mean_focal_px() * rig.cameras[1].mean_focal_px());
}

double Width(const ScaleCheck::Scale& scale) {
  return scale.high - scale.low + 2 * scale.sigma;
}

bool AreDisjoint(const ScaleCheck::Scale& a, const ScaleCheck::Scale& b) {
  const double margin = 2 * std::hypot(a.sigma, b.sigma);
  return a.low > b.high + margin || b.low > a.high + margin;
}

}  // namespace

MotionCheck::MotionCheck(const StereoRig& rig)
    : motion_(rig), given_motion_(rig), size_px_m_(SizeOf(rig)), by_images_(kMostLegsOfImages) {
  by_images_.SetGyroScale(rig.gyro_scale);
  by_states_.SetGyroScale(rig.gyro_scale);
}

void MotionCheck::DistrustAccelerometer() {
  by_images_.DistrustAccelerometer();
  by_states_.DistrustAccelerometer();
}

// Images alone measure the size by the calibration that there is. What makes it wrong beyond hope
// is not made good by what the estimator changes.
void MotionCheck::WorldHasChanged() {
  if (!by_images_.IsHopeless()) {
    motion_.ForgetPoints();
    by_images_.WorldHasChanged();
  }
  by_states_.WorldHasChanged(kStatesSettle);
  has_given_rig_ = has_doubted_ = false;
}

bool MotionCheck::SetRig(const StereoRig& rig) {
  motion_.SetRig(rig);
  by_images_.SetGyroScale(rig.gyro_scale);
  by_states_.SetGyroScale(rig.gyro_scale);
  const double size_px_m = SizeOf(rig);
  const double change = std::abs(size_px_m / size_px_m_ - 1);
  if (change <= kSameSize) return false;
  size_px_m_ = size_px_m;
  if (change > kLargeChange || !by_images_.IsHopeless()) {
    motion_.ForgetPoints();
    by_images_.BeginAnew();
  }
  by_states_.BeginAnew();
  has_given_rig_ = has_doubted_ = false;
  return true;
}

void MotionCheck::AddImu(const ImuInterval& imu) {
  by_states_.AddImu(imu);
  const Vector3d bias = gyro_bias_.value_or(Vector3d::Zero());
  if (!turns_.IsDone()) given_motion_.AddImu(imu, bias);
  if (by_images_.IsDone()) return;
  motion_.AddImu(imu, bias);
  by_images_.AddImu(imu);
}

ScaleCheck::Finding MotionCheck::AddKeyframe(const FrameObservations& seen, const NavState* state) {
  using enum ScaleCheck::Finding;
  if (state != nullptr) gyro_bias_ = state->bias.b_g;
  AddTurn(seen);
  const ScaleCheck::Finding of_images = AddImages(seen);
  const ScaleCheck::Finding of_states =
      state != nullptr ? by_states_.AddKeyframe(*state) : kNothing;
  was_found_by_images_ = of_images >= of_states;
  const ScaleCheck::Finding finding = was_found_by_images_ ? of_images : of_states;
  if (finding != kDoubt) return finding;
  return std::exchange(has_doubted_, true) ? kNothing : kDoubt;
}

void MotionCheck::AddTurn(const FrameObservations& seen) {
  if (!gyro_bias_ || turns_.IsDone()) return;
  given_motion_.AddKeyframe(seen);
  if (given_motion_.turn() && turns_.Add(*given_motion_.turn())) has_doubted_turns_ = true;
  if (turns_.DoAxesAgree()) by_images_.TrustGyroscope();
}

ScaleCheck::Finding MotionCheck::AddImages(const FrameObservations& seen) {
  if (!gyro_bias_ || by_images_.IsDone()) return ScaleCheck::Finding::kNothing;
  NavState x;
  x.t = seen.t;
  x.T_WB = motion_.AddKeyframe(seen);
  x.bias.b_g = *gyro_bias_;
  if (!motion_.turn()) by_images_.Break();
  if (motion_.HasLostOrientation()) by_images_.LoseOrientation();
  return by_images_.AddKeyframe(x);
}

std::optional<TurnCheck::Ratio> MotionCheck::TakeDoubtOfTurns() {
  return std::exchange(has_doubted_turns_, false) ? turns_.ratio() : std::nullopt;
}

const std::optional<ScaleCheck::Scale>& MotionCheck::scale() const {
  const auto &images = by_images_.scale(), &states = by_states_.scale();
  if (!images || !states) return images ? images : states;
  // States may have given way to what the accelerometer says.
  if (AreDisjoint(*images, *states)) return images;
  return Width(*images) < Width(*states) ? images : states;
}

}  // namespace facet
