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
// Positions farther away are of no use to anybody.
constexpr double kFarthest_m = 1e4;

double Square(double x) {
  return x * x;
}

}  // namespace

// Two hypotheses: right, or wrong with kWrongSigma. The measurement of the size weighs them, and
// says how wrong.
double SizeVariance(const std::optional<ScaleCheck::Scale>& scale) {
  constexpr double kWrong = kWrongSigma * kWrongSigma;
  if (!scale) return kWrongShare * kWrong;
  // The truth is anywhere between the two bounds, and each of them has that sigma.
  const double error = scale->value() - 1;
  const double half_width = 0.5 * (scale->high - scale->low);
  const double noise = Square(scale->sigma) + Square(half_width) / 3 + Square(kAccelScaleSigma);
  const double if_right = noise, if_wrong = noise + kWrong;
  const double right_to_wrong = (1 - kWrongShare) / kWrongShare * std::sqrt(if_wrong / if_right) *
                                std::exp(-0.5 * Square(error) * (1 / if_right - 1 / if_wrong));
  const double gain = kWrong / if_wrong;
  return (Square(gain * error) + gain * noise) / (1 + right_to_wrong);
}

void SizeDoubt::AddKeyframe(const NavState& x, const std::optional<ScaleCheck::Scale>& scale) {
  if (!x.T_WB.p.allFinite()) return;
  if (!origin_) origin_ = x.T_WB.p;
  last_ = x.T_WB.p;
  variance_ = SizeVariance(scale);
}

void SizeDoubt::WorldHasChanged() {
  if (!origin_) return;
  const Vector3d way = WayTo(last_);
  astray_ += variance_ * way * way.transpose();
  origin_ = last_;
  variance_ = SizeVariance({});
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
