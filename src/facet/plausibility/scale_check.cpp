// SPDX-License-Identifier: BSD-2-Clause
#include "facet/plausibility/scale_check.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <span>
#include <utility>

namespace facet {
namespace {

// Keyframes nearer than this are left out: of two positions a millimetre apart no acceleration can
// be told. Later than that the gyroscope's errors count.
constexpr double kShortest_s = 0.15, kLongest_s = 1.0;
constexpr int kRowsPerLegs = 3;
// The least before anything is said, and how often it is said anew.
constexpr int kLeastLegs = 20, kLegsPerFit = 10;
// Refusals: whoever has the units or axes wrong is told so by the gyroscope, which takes some
// seconds; and a run that has gone well for a minute is not refused any more.
constexpr int kLeastLegsForRefusal = 40, kMostLegsForRefusal = 300;
// Of the accelerometer [m/s^2].
constexpr double kBiasSigma = 0.5;
// Neighbours share a position, so their errors are not independent.
constexpr double kCorrelated = 1.5;
constexpr LineNoise kNoise = {kBiasSigma, kCorrelated};
// The least that is worth telling (a calibrated accelerometer's own scale is off by some 0.3 %),
// and that makes a run useless.
constexpr double kLeastDoubt = 0.01, kLeastRefusal = 0.15, kSureSigmas = 2.8;
constexpr double kSigmaOfKnown = 0.05;
// Early fits have poses in them that were not settled: a doubt has to last.
constexpr int kDoubtsInARow = 3;
// Where the gyroscope's axes are wrong, too, that is told first.
constexpr int kLeastLegsForAxes = 60;
// Noise draws the factor of an axis from 1 towards 0, never beyond.
constexpr double kLeastNegated = 0.2, kSureNegatedSigmas = 2.5;

}  // namespace

void ScaleCheck::AddImu(const ImuInterval& imu) {
  if (!second_) return;
  if (imu.samples.empty() || imu.has_hole || second_->imu.dt_s() > kLongest_s) {
    Break();
  } else {
    second_->imu.Integrate(imu.samples);
  }
}

ScaleCheck::Finding ScaleCheck::AddKeyframe(const NavState& state) {
  Finding finding = Finding::kNothing;
  if (IsDone()) return finding;
  if (settles_) settled_at_ = state.t + *settles_;
  settles_.reset();
  if (state.t < settled_at_) return finding;
  if (second_) {
    if (second_->imu.dt_s() < kShortest_s) return finding;
    if (first_) AddRows(*first_, *second_, state);
    if (first_ && rows_.size() % (kRowsPerLegs * kLegsPerFit) == 0) finding = Judge();
    first_ = std::move(second_);
  }
  second_ = Leg{state, ForceIntegral(state.bias.b_g, gyro_scale_)};
  return finding;
}

bool ScaleCheck::IsDone() const {
  return static_cast<int>(rows_.size() - num_rows_before_) >= kRowsPerLegs * most_legs_;
}

void ScaleCheck::Break() {
  first_.reset();
  second_.reset();
}

void ScaleCheck::BeginAnew() {
  Break();
  constexpr std::size_t kKept = kRowsPerLegs * (kMostLegsForRefusal + 1);
  if (rows_.size() > kKept) rows_.resize(kKept);  // no memory for those that count no more
  num_rows_before_ = rows_.size();
  scale_.reset();
  num_doubts_ = 0;
  has_doubted_ = is_hopeless_ = false;
}

void ScaleCheck::LoseOrientation() {
  BeginAnew();
  num_rows_forgotten_ += rows_.size();
  rows_.clear();
  num_rows_before_ = 0;
}

void ScaleCheck::WorldHasChanged(Duration settles) {
  BeginAnew();
  is_accel_trusted_ = true;
  settles_ = settles;
}

bool ScaleCheck::IsHopeless() const {
  return scale_ && scale_->IsOff(kLeastRefusal, kSureSigmas);
}

// From one leg to the next the mean velocity changes by s (g (T1 + T2) / 2 + a), where a is what
// the accelerometer says without gravity and bias, and s the scale: the velocity at the keyframe
// between them drops out.
void ScaleCheck::AddRows(const Leg& first, const Leg& second, const NavState& end) {
  const double T1 = first.imu.dt_s(), T2 = second.imu.dt_s();
  const Matrix3d R1 = first.begin.T_WB.R(), R2 = second.begin.T_WB.R();
  const Vector3d change =
      (end.T_WB.p - second.begin.T_WB.p) / T2 - (second.begin.T_WB.p - first.begin.T_WB.p) / T1;
  const auto from_leg_to_leg = [&](const ForceIntegral::ByAxis& a,
                                   const ForceIntegral::ByAxis& b) -> Matrix3d {
    return R1 * (a.velocity - a.displacement / T1) + R2 * (b.displacement / T2);
  };
  const Matrix3d by_axis = from_leg_to_leg(first.imu.measured(), second.imu.measured());
  const Matrix3d of_bias = from_leg_to_leg(first.imu.constant(), second.imu.constant());
  for (int axis = 0; axis < 3; ++axis) {
    Row row;
    row.velocity = change(axis);
    row.force_by_axis = by_axis.row(axis).transpose();
    row.constants << 0.5 * (T1 + T2) * Vector3d::Unit(axis), of_bias.row(axis).transpose();
    rows_.push_back(row);
  }
}

std::optional<ScaleCheck::Scale> ScaleCheck::Fit() const {
  const auto force = [](const Row& row) { return row.force_by_axis.sum(); };
  const auto velocity = [](const Row& row) { return row.velocity; };
  const auto rows = std::span(rows_).subspan(num_rows_before_);
  return FitFactor(rows, force, velocity, kNoise);
}

std::string ScaleCheck::FindNegatedAxes() const {
  const auto line = FitLine<3>(
      std::span(rows_),
      [](const Row& row) { return row.force_by_axis; },
      [](const Row& row) { return row.velocity; },
      kNoise);
  std::string axes;
  for (int k = 0; line && k < 3; ++k) {
    if (line->slope(k) < -std::max(kLeastNegated, kSureNegatedSigmas * line->sigma(k)))
      axes += "xyz"[k];
  }
  return axes;
}

ScaleCheck::Finding ScaleCheck::Judge() {
  const int num_known_legs = static_cast<int>(rows_.size()) / kRowsPerLegs;
  const int num_all_legs = num_known_legs + static_cast<int>(num_rows_forgotten_) / kRowsPerLegs;
  if (num_known_legs >= kLeastLegs && num_all_legs <= kMostLegsForRefusal) {
    // What was clear once stays so: with a wrong accelerometer the poses become worse and worse.
    if (negated_axes_.empty()) negated_axes_ = FindNegatedAxes();
    const int least = is_gyro_trusted_ ? kLeastLegsForRefusal : kLeastLegsForAxes;
    if (!negated_axes_.empty() && num_all_legs >= least) return Finding::kAxesTheOtherWay;
  }
  const int num_legs = num_known_legs - static_cast<int>(num_rows_before_) / kRowsPerLegs;
  if (num_legs < kLeastLegs) return Finding::kNothing;
  scale_ = Fit();
  if (!scale_) return Finding::kNothing;
  // Whatever changes after the size was right once is no calibration.
  if (scale_->sigma < kSigmaOfKnown && !scale_->IsOff(kLeastRefusal, 0)) was_right_ = true;
  const bool is_useless = !was_right_ && num_all_legs <= kMostLegsForRefusal &&
                          scale_->IsOff(kLeastRefusal, kSureSigmas);
  // An estimator gives way to a wrong size, so what was clear once stays so; but not what an
  // accelerometer said whose bias was running away.
  if (is_useless && is_accel_trusted_) is_hopeless_ = true;
  if ((is_useless || is_hopeless_) && num_legs >= kLeastLegsForRefusal) return Finding::kRefusal;
  num_doubts_ = scale_->IsOff(kLeastDoubt, kSureSigmas) ? num_doubts_ + 1 : 0;
  if (has_doubted_ || num_doubts_ < kDoubtsInARow) return Finding::kNothing;
  has_doubted_ = true;
  return Finding::kDoubt;
}

std::string NegatedAxesInWords(const std::string& axes) {
  std::string what = "the accelerometer shows";
  if (axes.size() < 3) {
    what = axes.size() == 1 ? "an axis of the accelerometer, " : "two axes of the accelerometer, ";
    for (std::size_t k = 0; k < axes.size(); ++k)
      what += std::string(k > 0 ? " and " : "") + axes[k];
    what += axes.size() == 1 ? ", shows" : ", show";
  }
  return what +
         " the opposite of what the cameras see: at rest it must measure +9.8 upwards; check the "
         "signs of a_RS_S in imu0/data.csv and T_BS, or T_cam_imu";
}

std::string InWords(const ScaleCheck::Scale& scale) {
  if (scale.high < 0) return NegatedAxesInWords("xyz");
  char text[400];
  std::snprintf(text,
                sizeof(text),
                "the stereo pair makes the world %.1f %% (1-sigma %.1f) too %s for the "
                "accelerometer: check the distance between the cameras (T_BS of both cameras, or "
                "T_cn_cnm1; metres), the focal lengths, and the accelerometer's scale",
                100 * std::abs(scale.value() - 1),
                100 * scale.sigma,
                scale.value() > 1 ? "large" : "small");
  return text;
}

}  // namespace facet
