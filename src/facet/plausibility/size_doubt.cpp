// SPDX-License-Identifier: BSD-2-Clause
#include "facet/plausibility/size_doubt.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "facet/geometry/so3.h"

namespace facet {
namespace {

// Of ten calibrations of users one is wrong by some percent: the baseline of a data sheet, the
// focal length of another resolution or of a lens that was turned.
constexpr double kWrongShare = 0.1, kWrongSigma = 0.02;
// The accelerometer's own scale.
constexpr double kAccelScaleSigma = 0.003;
// What careful focal lengths and a calibrated gyroscope leave of turns.
constexpr double kTurnSigma = 0.002;
// Probability that turns are wrong from which on they are doubted, which is about when it is told:
// they add up for as long as a run lasts, so that a little doubt would become a large one.
constexpr double kLeastShareWrong = 0.2;
// Of a heading that is not known at all [rad^2].
constexpr double kUnknownHeading = std::numbers::pi * std::numbers::pi / 3;
// Positions farther away are of no use to anybody.
constexpr double kFarthest_m = 1e4;

double Square(double x) {
  return x * x;
}

// An error that was measured. Two hypotheses: right, or wrong with kWrongSigma. The measurement
// weighs them, and says how wrong.
struct Judgement {
  double variance = 0;
  double share_wrong = 0;  // probability
};

// `own_sigma`: what right calibrations leave of the error.
Judgement Judge(const FactorBounds& measured, double own_sigma) {
  constexpr double kWrong = kWrongSigma * kWrongSigma;
  // The truth is anywhere between the two bounds, and each of them has that sigma.
  const double error = measured.value() - 1;
  const double half_width = 0.5 * (measured.high - measured.low);
  const double noise = Square(measured.sigma) + Square(half_width) / 3 + Square(own_sigma);
  const double if_right = noise, if_wrong = noise + kWrong;
  const double right_to_wrong = (1 - kWrongShare) / kWrongShare * std::sqrt(if_wrong / if_right) *
                                std::exp(-0.5 * Square(error) * (1 / if_right - 1 / if_wrong));
  const double gain = kWrong / if_wrong;
  const double share_wrong = 1 / (1 + right_to_wrong);
  return {(Square(gain * error) + gain * noise) * share_wrong, share_wrong};
}

// What turns say beyond what as vague a measurement without any error would say: to know little of
// turns is no reason to doubt them, or a size that is known.
Judgement JudgeTurns(const TurnCheck::Ratio& turns) {
  const double half_width = 0.5 * (turns.high - turns.low);
  const FactorBounds as_should_be{1 - half_width, 1 + half_width, turns.sigma};
  Judgement judgement = Judge(turns, kTurnSigma);
  judgement.variance -= Judge(as_should_be, kTurnSigma).variance;
  return judgement;
}

Vector3d Way(const Vector3d& from_W, const Vector3d& to_W) {
  return (to_W - from_W).cwiseMin(kFarthest_m).cwiseMax(-kFarthest_m);
}

bool HasPose(const NavState& x) {
  return x.T_WB.p.allFinite() && x.T_WB.q.coeffs().allFinite();
}

}  // namespace

double SizeVariance(const std::optional<ScaleCheck::Scale>& scale,
                    const std::optional<TurnCheck::Ratio>& turns) {
  const double of_size =
      scale ? Judge(*scale, kAccelScaleSigma).variance : kWrongShare * Square(kWrongSigma);
  return turns ? std::max(of_size, JudgeTurns(*turns).variance) : of_size;
}

TurnDoubt DoubtOfTurns(const std::optional<TurnCheck::Ratio>& turns) {
  if (!turns) return {};
  const Judgement judgement = JudgeTurns(*turns);
  return {judgement.variance, judgement.share_wrong};
}

void SizeDoubt::AddKeyframe(const NavState& x,
                            const std::optional<ScaleCheck::Scale>& scale,
                            const std::optional<TurnCheck::Ratio>& turns) {
  if (!HasPose(x)) return;
  if (!since_) since_ = last_ = Reached{x.T_WB};
  last_ = is_lost_ ? Reached{x.T_WB, last_->heading_rad, last_->turned_way_W} : ReachedAt(x.T_WB);
  is_lost_ = false;
  size_variance_ = SizeVariance(scale, turns);
  const TurnDoubt doubt = DoubtOfTurns(turns);
  are_turns_doubted_ |= doubt.share_wrong > kLeastShareWrong;
  turn_variance_ = are_turns_doubted_ ? doubt.variance : 0;
}

void SizeDoubt::WorldHasChanged() {
  if (!last_) return;
  const Vector3d way = Way(since_->T_WB.p, last_->T_WB.p);
  astray_ += size_variance_ * way * way.transpose();
  if (turn_variance_ > 0) turned_astray_.push_back(AstrayAt(*last_));
  since_ = last_;
  size_variance_ = SizeVariance({}, {});
  turn_variance_ = 0;
  are_turns_doubted_ = false;
}

SizeDoubt::Reached SizeDoubt::ReachedAt(const SE3& T_WB) const {
  const double turn_rad = LogSO3(T_WB.q * last_->T_WB.q.conjugate()).z();
  const Vector3d way = Way(last_->T_WB.p, T_WB.p);
  const double mean_rad = last_->heading_rad + 0.5 * turn_rad;
  return {T_WB, last_->heading_rad + turn_rad, last_->turned_way_W + mean_rad * way};
}

SizeDoubt::Astray SizeDoubt::AstrayAt(const Reached& now) const {
  return {turn_variance_,
          now.heading_rad - since_->heading_rad,
          now.turned_way_W - since_->turned_way_W -
              since_->heading_rad * Way(since_->T_WB.p, now.T_WB.p),
          now.T_WB.p};
}

Matrix<15, 15> SizeDoubt::CovarianceOf(const NavState& x) const {
  Matrix<15, 15> covariance = Matrix<15, 15>::Zero();
  if (!last_ || !HasPose(x) || !x.v_WB.allFinite()) return covariance;
  Vector<6> way_and_velocity;
  way_and_velocity << Way(since_->T_WB.p, x.T_WB.p), x.v_WB;
  covariance.block<6, 6>(3, 3) = size_variance_ * way_and_velocity * way_and_velocity.transpose();
  covariance.block<3, 3>(3, 3) += astray_;
  const auto add = [&](const Astray& astray) {
    const Vector3d up(0, 0, 1);
    const Vector3d way = Way(astray.p_W, x.T_WB.p);
    Vector<9> led_astray;
    led_astray << x.T_WB.q.conjugate() * (astray.heading_rad * up),
        up.cross(astray.turned_way_W + astray.heading_rad * way),
        up.cross(astray.heading_rad * x.v_WB);
    const double of_heading = astray.variance * astray.heading_rad * astray.heading_rad;
    const double share = of_heading > kUnknownHeading ? kUnknownHeading / of_heading : 1;
    covariance.topLeftCorner<9, 9>() +=
        share * astray.variance * led_astray * led_astray.transpose();
  };
  for (const Astray& astray : turned_astray_)
    add(astray);
  if (turn_variance_ > 0) add(AstrayAt(ReachedAt(x.T_WB)));
  return covariance;
}

}  // namespace facet
