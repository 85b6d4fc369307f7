// SPDX-License-Identifier: BSD-2-Clause
#include "facet/plausibility/size_doubt.h"

#include <algorithm>
#include <cmath>

namespace facet {
namespace {

// Of ten calibrations of users one is wrong by some percent: the baseline of a data sheet, the
// focal length of another resolution or of a lens that was turned.
constexpr double kWrongShare = 0.1, kWrongSigma = 0.02;
// The accelerometer's own scale.
constexpr double kAccelScaleSigma = 0.003;
// What careful focal lengths and a calibrated gyroscope leave of turns.
constexpr double kTurnSigma = 0.002;
// Positions farther away are of no use to anybody.
constexpr double kFarthest_m = 1e4;

double Square(double x) {
  return x * x;
}

// Variance of an error that was measured. Two hypotheses: right, or wrong with kWrongSigma. The
// measurement weighs them, and says how wrong. `own_sigma`: what it leaves of right calibrations.
double VarianceAfter(const FactorBounds& measured, double own_sigma) {
  constexpr double kWrong = kWrongSigma * kWrongSigma;
  // The truth is anywhere between the two bounds, and each of them has that sigma.
  const double error = measured.value() - 1;
  const double half_width = 0.5 * (measured.high - measured.low);
  const double noise = Square(measured.sigma) + Square(half_width) / 3 + Square(own_sigma);
  const double if_right = noise, if_wrong = noise + kWrong;
  const double right_to_wrong = (1 - kWrongShare) / kWrongShare * std::sqrt(if_wrong / if_right) *
                                std::exp(-0.5 * Square(error) * (1 / if_right - 1 / if_wrong));
  const double gain = kWrong / if_wrong;
  return (Square(gain * error) + gain * noise) / (1 + right_to_wrong);
}

}  // namespace

double SizeVariance(const std::optional<ScaleCheck::Scale>& scale,
                    const std::optional<TurnCheck::Ratio>& turns) {
  const double of_size =
      scale ? VarianceAfter(*scale, kAccelScaleSigma) : kWrongShare * kWrongSigma * kWrongSigma;
  if (!turns) return of_size;
  // What turns say beyond what as vague a measurement without any error would say: to know little
  // of turns is no reason to doubt a size that is known.
  const double half_width = 0.5 * (turns->high - turns->low);
  const FactorBounds as_should_be{1 - half_width, 1 + half_width, turns->sigma};
  return std::max(of_size,
                  VarianceAfter(*turns, kTurnSigma) - VarianceAfter(as_should_be, kTurnSigma));
}

void SizeDoubt::AddKeyframe(const NavState& x,
                            const std::optional<ScaleCheck::Scale>& scale,
                            const std::optional<TurnCheck::Ratio>& turns) {
  if (!x.T_WB.p.allFinite()) return;
  if (!origin_) origin_ = x.T_WB.p;
  last_ = x.T_WB.p;
  variance_ = SizeVariance(scale, turns);
}

void SizeDoubt::WorldHasChanged() {
  if (!origin_) return;
  const Vector3d way = WayTo(last_);
  astray_ += variance_ * way * way.transpose();
  origin_ = last_;
  variance_ = SizeVariance({}, {});
}

Vector3d SizeDoubt::WayTo(const Vector3d& p_W) const {
  return (p_W - *origin_).cwiseMin(kFarthest_m).cwiseMax(-kFarthest_m);
}

Matrix<15, 15> SizeDoubt::CovarianceOf(const NavState& x) const {
  Matrix<15, 15> covariance = Matrix<15, 15>::Zero();
  if (!origin_ || !x.T_WB.p.allFinite() || !x.v_WB.allFinite()) return covariance;
  Vector<6> way_and_velocity;
  way_and_velocity << WayTo(x.T_WB.p), x.v_WB;
  covariance.block<6, 6>(3, 3) = variance_ * way_and_velocity * way_and_velocity.transpose();
  covariance.block<3, 3>(3, 3) += astray_;
  return covariance;
}

}  // namespace facet
