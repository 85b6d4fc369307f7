// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/contradiction.h"

#include <cmath>

#include "facet/geometry/so3.h"

namespace facet {
namespace {

constexpr Duration kRecent{1'000'000'000};
constexpr double kForgets_s = 5;
// More than this is as unknown as can be.
constexpr double kMostTurn = M_PI, kMostShift_m = 1e4, kMostSpeed = 100;

}  // namespace

// Differences of neighbouring keyframes have one cause and add up.
void Contradiction::Add(const ImuLink& link,
                        const NavState& begin,
                        const NavState& end,
                        double error_sigma) {
  if (!(error_sigma > kContradictionSigma)) return;
  const NavState predicted = link.measured.Predict(begin);
  const Vector3d turn = LogSO3(predicted.T_WB.q.conjugate() * end.T_WB.q).cwiseAbs();
  const Vector3d shift = (predicted.T_WB.p - end.T_WB.p).cwiseAbs();
  const Vector3d speed = (predicted.v_WB - end.v_WB).cwiseAbs();
  if (!turn.allFinite() || !shift.allFinite() || !speed.allFinite()) return;
  if (t_) {
    const double dt_s = ToSeconds(end.t - *t_);
    p_ = PositionAt(dt_s);
    v_ *= std::exp(-dt_s / kForgets_s);
  }
  t_ = end.t;
  theta_ = (theta_ + turn).cwiseMin(kMostTurn);
  p_ = (p_ + shift).cwiseMin(kMostShift_m);
  v_ = (v_ + speed).cwiseMin(kMostSpeed);
}

Vector3d Contradiction::PositionAt(double seconds_later) const {
  return p_ + kForgets_s * (1 - std::exp(-seconds_later / kForgets_s)) * v_;
}

Matrix<15, 15> Contradiction::CovarianceAt(Timestamp t) const {
  Matrix<15, 15> covariance = Matrix<15, 15>::Zero();
  if (!t_) return covariance;
  const double dt_s = ToSeconds(t - *t_);
  covariance.diagonal().head<3>() = theta_.cwiseAbs2();
  covariance.diagonal().segment<3>(3) = PositionAt(dt_s).cwiseAbs2();
  covariance.diagonal().segment<3>(6) = (std::exp(-dt_s / kForgets_s) * v_).cwiseAbs2();
  return covariance;
}

bool Contradiction::IsRecentAt(Timestamp t) const {
  return t_ && t - *t_ < kRecent;
}

}  // namespace facet
