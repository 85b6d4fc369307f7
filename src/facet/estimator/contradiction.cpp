// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/contradiction.h"

#include <algorithm>
#include <cmath>

#include "facet/estimator/factors/imu_factor.h"
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
  const Vector3d turn = (end.T_WB.q * LogSO3(predicted.T_WB.q.conjugate() * end.T_WB.q)).cwiseAbs();
  const Vector3d shift = (predicted.T_WB.p - end.T_WB.p).cwiseAbs();
  const Vector3d speed = (predicted.v_WB - end.v_WB).cwiseAbs();
  if (!turn.allFinite() || !shift.allFinite() || !speed.allFinite()) return;
  MoveTo(end.t);
  p_ += AstrayAt(end.T_WB.p).cwiseAbs();
  place_ = end.T_WB.p;
  theta_ = (theta_ + turn).cwiseMin(kMostTurn);
  p_ = (p_ + shift).cwiseMin(kMostShift_m);
  v_ = (v_ + speed).cwiseMin(kMostSpeed);
}

Vector3d Contradiction::PositionAt(double seconds_later) const {
  return p_ + kForgets_s * (1 - std::exp(-seconds_later / kForgets_s)) * v_;
}

Vector3d Contradiction::AstrayAt(const Vector3d& p_W) const {
  const Vector3d astray = theta_.z() * Vector3d::UnitZ().cross(p_W - place_);
  return astray.cwiseMin(kMostShift_m).cwiseMax(-kMostShift_m);
}

void Contradiction::MoveTo(Timestamp t) {
  if (t_) {
    const double dt_s = ToSeconds(t - *t_);
    p_ = PositionAt(dt_s);
    v_ *= std::exp(-dt_s / kForgets_s);
  }
  t_ = t;
}

double Contradiction::Tilt::AngleAt(Timestamp later) const {
  return angle * std::exp(-ToSeconds(later - t) / kForgets_s);
}

// A tilted world leads astray with the distance.
double Contradiction::Tilt::AstrayAt(const NavState& x) const {
  return std::min(astray_m + AngleAt(x.t) * (x.T_WB.p - place).norm(), kMostShift_m);
}

void Contradiction::AddTilt(const NavState& x, double tilt) {
  if (!(tilt > 0) || !x.T_WB.p.allFinite()) return;
  const double left = tilt_ ? tilt_->AngleAt(x.t) : 0;
  const double astray_m = tilt_ ? tilt_->AstrayAt(x) : 0;
  tilt_ = Tilt{x.t, x.T_WB.p, std::min(std::max(left, tilt), kMostTurn), astray_m};
}

void Contradiction::StartOver(Timestamp t) {
  if (tilt_) tilt_->angle = 0;
  if (!t_) return;
  const Timestamp last = *t_;
  MoveTo(t);
  t_ = last;  // how recent it is stays as it was
  theta_.head<2>().setZero();
  v_.setZero();
}

Matrix<15, 15> Contradiction::CovarianceOf(const NavState& x) const {
  Matrix<15, 15> covariance = Matrix<15, 15>::Zero();
  const Matrix3d R = x.T_WB.R();
  if (t_) {
    const double dt_s = ToSeconds(x.t - *t_);
    covariance.topLeftCorner<3, 3>() = R.transpose() * theta_.cwiseAbs2().asDiagonal() * R;
    const Vector3d astray = AstrayAt(x.T_WB.p);
    covariance.block<3, 3>(3, 3) = astray * astray.transpose();
    covariance.diagonal().segment<3>(3) += PositionAt(dt_s).cwiseAbs2();
    covariance.diagonal().segment<3>(6) = (std::exp(-dt_s / kForgets_s) * v_).cwiseAbs2();
  }
  if (tilt_) {
    const double tilt = tilt_->AngleAt(x.t), astray_m = tilt_->AstrayAt(x);
    const Vector3d level(tilt * tilt, tilt * tilt, 0);
    covariance.topLeftCorner<3, 3>() += R.transpose() * level.asDiagonal() * R;
    covariance.diagonal().segment<3>(3).array() += astray_m * astray_m;
    covariance.diagonal().segment<3>(6).array() += tilt * tilt * x.v_WB.squaredNorm();
  }
  return covariance;
}

bool Contradiction::IsRecentAt(Timestamp t) const {
  return t_ && t - *t_ < kRecent;
}

}  // namespace facet
