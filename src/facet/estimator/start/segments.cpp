// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/start/segments.h"

#include <cmath>
#include <numbers>

namespace facet {

namespace {

// Maps and planes agree within centimetres, places that are recognised again within decimetres.
constexpr double kMaxBlindDrift_m = 0.3;
// What a broken IMU leads to is not believed: then the body is near where it was lost.
constexpr double kMaxReckonedSpeed = 30;  // m/s
// Nor where it leads to anywhere on a continent: such covariances drown all others in rounding.
constexpr double kMaxReckonedSigma_m = 1e5;
constexpr double kUnknownSpeedSigma = 5;  // m/s
constexpr double kUnknownHeadingSigma = std::numbers::pi / 1.7320508;

// d (theta p v b_g b_a) / d (x, y, z, heading) when the segment is moved, and turned about its
// origin.
Matrix<15, 4> MotionOfSegment(const NavState& x, const Vector3d& origin) {
  Matrix<15, 4> J = Matrix<15, 4>::Zero();
  J.block<3, 3>(3, 0).setIdentity();
  J.block<3, 1>(0, 3) = x.T_WB.q.conjugate() * Vector3d::UnitZ();
  J.block<3, 1>(3, 3) = Vector3d::UnitZ().cross(x.T_WB.p - origin);
  J.block<3, 1>(6, 3) = Vector3d::UnitZ().cross(x.v_WB);
  return J;
}

double PositionSigma(const Matrix<15, 15>& covariance) {
  return std::sqrt(std::max(covariance.block<3, 3>(3, 3).trace(), 0.0));
}

bool IsBelievable(const ReckonedState& state) {
  return state.x.T_WB.p.allFinite() && state.x.T_WB.q.coeffs().allFinite() &&
         state.covariance.allFinite() && state.x.v_WB.norm() < kMaxReckonedSpeed &&
         PositionSigma(state.covariance) < kMaxReckonedSigma_m;
}

}  // namespace

void Segments::Keep(const NavState& x, const Matrix<15, 15>& covariance, bool is_seen) {
  reckoned_ = {x, InWorld(covariance, x)};
  if (is_seen) seen_sigma_p_m_ = PositionSigma(reckoned_.covariance);
}

bool Segments::HasDriftedAway(const NavState& x, const Matrix<15, 15>& covariance) const {
  return PositionSigma(InWorld(covariance, x)) > seen_sigma_p_m_ + kMaxBlindDrift_m;
}

void Segments::End(const ImuLink* link) {
  is_between_ = id_ >= 0;
  if (is_between_ && link != nullptr) Follow(*link);
}

void Segments::Follow(const ImuLink& link) {
  ReckonedState next = Reckon(reckoned_, link.measured, walk_);
  if (!IsBelievable(next)) {
    const double T = link.measured.dt();
    const Timestamp t = next.x.t;
    next = reckoned_;
    next.x.t = t;
    next.x.v_WB.setZero();
    // As if it had moved at a speed of its own for each interval: sigmas add up, not variances.
    const double sigma_p = std::sqrt(std::max(next.covariance(3, 3), 0.0)) + kUnknownSpeedSigma * T;
    next.covariance = Matrix<15, 15>(next.covariance.diagonal().asDiagonal());
    next.covariance.diagonal().segment<3>(0).setConstant(std::pow(kUnknownHeadingSigma, 2));
    next.covariance.diagonal().segment<3>(3).setConstant(std::pow(sigma_p, 2));
    next.covariance.diagonal().segment<3>(6).setConstant(std::pow(kUnknownSpeedSigma, 2));
  }
  reckoned_ = next;
}

std::optional<SE3> Segments::PredictedPose() const {
  if (!is_between_) return std::nullopt;
  return reckoned_.x.T_WB;
}

void Segments::Begin(const NavState& newest) {
  ++id_;
  origin_ = newest.T_WB.p;
  origin_covariance_.setZero();
  if (is_between_) {
    // Place and heading are all that is taken over.
    Matrix<4, 15> J = Matrix<4, 15>::Zero();
    J.block<3, 3>(0, 3).setIdentity();
    J.block<1, 3>(3, 0) = reckoned_.x.T_WB.R().row(2);
    origin_covariance_ = J * reckoned_.covariance * J.transpose();
  }
  is_between_ = false;
}

Matrix<15, 15> Segments::InWorld(const Matrix<15, 15>& covariance, const NavState& x) const {
  const Matrix<15, 4> J = MotionOfSegment(x, origin_);
  Matrix<15, 15> in_world = covariance + J * origin_covariance_ * J.transpose();
  // Only rounding could make anything better known in the world than within the segment.
  in_world.diagonal() = in_world.diagonal().cwiseMax(covariance.diagonal());
  return in_world;
}

}  // namespace facet
