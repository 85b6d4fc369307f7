// SPDX-License-Identifier: BSD-2-Clause
#include "facet/sim/spline_trajectory.h"

#include <algorithm>
#include <numbers>

#include <Eigen/SparseCholesky>

#include "facet/base/check.h"
#include "facet/base/random.h"

namespace facet {

namespace {

/// The degree + 1 basis functions of a uniform B-spline that are not zero at u in [0, 1] of a knot
/// interval (Cox - de Boor recursion).
template <int Degree>
std::array<double, Degree + 1> Basis(double u) {
  std::array<double, Degree + 1> basis{};
  basis[0] = 1;
  for (int d = 1; d <= Degree; ++d) {
    for (int i = d; i >= 0; --i) {
      const double left = i > 0 ? (u + d - i) / d * basis[i - 1] : 0.0;
      const double right = i < d ? (1 - u + i) / d * basis[i] : 0.0;
      basis[i] = left + right;
    }
  }
  return basis;
}

struct KnotPosition {
  int interval = 0;
  double u = 0;  // 0 .. 1 inside the interval
};

KnotPosition Locate(double seconds, double knot_interval_s, int num_intervals) {
  const double x = seconds / knot_interval_s;
  const int interval = std::clamp(static_cast<int>(x), 0, num_intervals - 1);
  return {interval, x - interval};
}

/// Adds weight * (third difference)^2 of n control points to the normal equations.
void AddSmoothing(double weight, int n, std::vector<Eigen::Triplet<double>>& entries) {
  constexpr std::array<double, 4> kThirdDifference = {-1, 3, -3, 1};
  for (int k = 0; k + 3 < n; ++k) {
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        entries.emplace_back(k + i, k + j, weight * kThirdDifference[i] * kThirdDifference[j]);
      }
    }
  }
}

}  // namespace

SplineTrajectory SplineTrajectory::Fit(std::span<const NavState> states,
                                       const SplineOptions& options) {
  FACET_CHECK(states.size() >= 2 && ToSeconds(states.back().t - states.front().t) >= 1.0)
      << states.size() << " poses are too few or too short a time";
  SplineTrajectory spline;
  spline.begin_ = states.front().t;
  spline.end_ = states.back().t;
  const double duration = ToSeconds(spline.end_ - spline.begin_);
  const int num_intervals =
      std::max(1, static_cast<int>(std::ceil(duration / options.knot_interval_s)));
  spline.knot_interval_s_ = duration / num_intervals;
  const int n = num_intervals + kDegree;

  // Normal equations A x = b, one column of x per component.
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::Matrix<double, Eigen::Dynamic, 7> b = Eigen::Matrix<double, Eigen::Dynamic, 7>::Zero(n, 7);
  Vector4d previous = states.front().T_WB.q.coeffs();
  for (const NavState& state : states) {
    Coefficients value;
    const Vector4d q = state.T_WB.q.coeffs();
    const double sign = q.dot(previous) < 0 ? -1.0 : 1.0;  // q and -q are the same rotation
    value << state.T_WB.p, sign * q;
    previous = sign * q;
    const KnotPosition at =
        Locate(ToSeconds(state.t - spline.begin_), spline.knot_interval_s_, num_intervals);
    const auto basis = Basis<kDegree>(at.u);
    for (int i = 0; i <= kDegree; ++i) {
      b.row(at.interval + i) += basis[i] * value.transpose();
      for (int j = 0; j <= kDegree; ++j) {
        entries.emplace_back(at.interval + i, at.interval + j, basis[i] * basis[j]);
      }
    }
  }
  AddSmoothing(options.smoothing, n, entries);
  Eigen::SparseMatrix<double> A(n, n);
  A.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(A);
  FACET_CHECK(solver.info() == Eigen::Success) << "the spline is not determined by its poses";
  const Eigen::Matrix<double, Eigen::Dynamic, 7> x = solver.solve(b);
  spline.control_points_.resize(n);
  for (int i = 0; i < n; ++i)
    spline.control_points_[i] = x.row(i).transpose();
  return spline;
}

std::array<SplineTrajectory::Coefficients, 3> SplineTrajectory::Evaluate(double seconds) const {
  const int num_intervals = static_cast<int>(control_points_.size()) - kDegree;
  const KnotPosition at = Locate(seconds, knot_interval_s_, num_intervals);
  // The derivative of a B-spline is one of a degree less, on the differences of its control points.
  std::array<Coefficients, kDegree + 1> points;
  std::copy_n(control_points_.begin() + at.interval, kDegree + 1, points.begin());
  const auto differentiate = [&](int count) {
    for (int i = 0; i < count; ++i)
      points[i] = (points[i + 1] - points[i]) / knot_interval_s_;
  };
  const auto sum = [&](const auto& basis) {
    Coefficients result = Coefficients::Zero();
    for (std::size_t i = 0; i < basis.size(); ++i)
      result += basis[i] * points[i];
    return result;
  };
  std::array<Coefficients, 3> result;
  result[0] = sum(Basis<kDegree>(at.u));
  differentiate(kDegree);
  result[1] = sum(Basis<kDegree - 1>(at.u));
  differentiate(kDegree - 1);
  result[2] = sum(Basis<kDegree - 2>(at.u));
  return result;
}

TrajectoryPoint SplineTrajectory::At(Timestamp t) const {
  FACET_CHECK(t >= begin_ && t <= end_) << t.ns << " is outside the trajectory";
  const auto [value, first, second] = Evaluate(ToSeconds(t - begin_));
  const Quaterniond q(Vector4d(value.tail<4>()));
  const Quaterniond q_dot(Vector4d(first.tail<4>()));
  TrajectoryPoint point;
  point.state.t = t;
  point.state.T_WB = SE3(q.normalized(), value.head<3>());
  point.state.v_WB = first.head<3>();
  // w = 2 Im(q* dq/dt) for unit q; a changing length only adds to the real part.
  point.w_B = 2 * (q.conjugate() * q_dot).vec() / q.squaredNorm();
  point.a_W = second.head<3>();
  return point;
}

ImuSample SplineTrajectory::IdealImuAt(Timestamp t) const {
  const TrajectoryPoint point = At(t);
  return {t, point.w_B, point.state.T_WB.q.conjugate() * (point.a_W - GravityInWorld())};
}

std::vector<NavState> MakeFlight(double duration_s, std::uint64_t seed) {
  constexpr double kTwoPi = 2 * std::numbers::pi;
  Rng rng(seed);
  // Per axis a slow and a fast sine: amplitude [m or rad], frequency [rad/s], phase.
  struct Sine {
    double amplitude, frequency, phase;
    double At(double t) const { return amplitude * std::sin(frequency * t + phase); }
  };
  const auto sine = [&](double amplitude, double hz_low, double hz_high) {
    return Sine{amplitude * rng.Uniform(0.8, 1.2),
                kTwoPi * rng.Uniform(hz_low, hz_high),
                rng.Uniform(0, kTwoPi)};
  };
  const std::array<Sine, 3> slow = {
      sine(1.6, 0.05, 0.08), sine(1.2, 0.06, 0.1), sine(0.4, 0.08, 0.15)};
  const std::array<Sine, 3> fast = {
      sine(0.15, 0.3, 0.6), sine(0.15, 0.3, 0.6), sine(0.1, 0.3, 0.6)};
  const std::array<Sine, 3> attitude = {
      sine(0.9, 0.08, 0.15), sine(0.12, 0.3, 0.7), sine(0.12, 0.3, 0.7)};
  const double yaw_rate = rng.Uniform(0.15, 0.4) * (rng.Index(2) ? 1 : -1);

  Matrix3d R_level;  // body axes at heading zero: x up, z forward
  R_level.col(0) = Vector3d::UnitZ();
  R_level.col(1) = -Vector3d::UnitY();
  R_level.col(2) = Vector3d::UnitX();
  std::vector<NavState> states;
  const int count = static_cast<int>(std::lround(duration_s * 200)) + 1;
  for (int i = 0; i < count; ++i) {
    const double t = i / 200.0;
    NavState state;
    state.t = Timestamp{1'000'000'000} + Duration{5'000'000LL * i};
    for (int k = 0; k < 3; ++k)
      state.T_WB.p(k) = slow[k].At(t) + fast[k].At(t);
    const Quaterniond yaw = ExpSO3(Vector3d(0, 0, yaw_rate * t + attitude[0].At(t)));
    const Quaterniond tilt = ExpSO3(Vector3d(0, attitude[1].At(t), attitude[2].At(t)));
    state.T_WB.q = (yaw * Quaterniond(R_level) * tilt).normalized();
    states.push_back(state);
  }
  return states;
}

}  // namespace facet
