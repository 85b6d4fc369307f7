// SPDX-License-Identifier: BSD-2-Clause
#include "facet/sim/spline_trajectory.h"

#include <algorithm>
#include <numbers>

#include <Eigen/SparseCholesky>

#include "facet/base/check.h"
#include "facet/base/random.h"
#include "facet/geometry/so3.h"

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

/// Weights of the degree + 1 control points in the derivative of an order (0: the value) at u.
template <int Degree, int Order>
std::array<double, Degree + 1> DerivativeWeights(double u, double knot_interval_s) {
  if constexpr (Order == 0) {
    return Basis<Degree>(u);
  } else {
    // The derivative of a B-spline is one of a degree less, on the differences of its points.
    const auto lower = DerivativeWeights<Degree - 1, Order - 1>(u, knot_interval_s);
    std::array<double, Degree + 1> weights{};
    for (int i = 0; i < Degree; ++i) {
      weights[i] -= lower[i] / knot_interval_s;
      weights[i + 1] += lower[i] / knot_interval_s;
    }
    return weights;
  }
}

/// Normal equations of control points with `Size` coupled components. Each row of the problem
/// touches degree + 1 neighbouring points, so that the matrix is a band of blocks.
template <int Size>
class NormalEquations {
 public:
  static constexpr int kReach = 6;
  using Block = Matrix<Size, Size>;
  using Column = Vector<Size>;

  explicit NormalEquations(int num_points)
      : band_(static_cast<std::size_t>(num_points)), b_(VectorXd::Zero(Size * num_points)) {
    for (auto& row : band_)
      row.fill(Block::Zero());
  }

  /// weight * |sum over i of weights[i] x[first + i] - value|^2.
  template <std::size_t N>
  void Add(int first, const std::array<double, N>& weights, const Column& value, double weight) {
    std::array<Block, N> blocks;
    for (std::size_t i = 0; i < N; ++i)
      blocks[i] = weights[i] * Block::Identity();
    Add(first, blocks, value, weight);
  }

  /// weight * |sum over i of blocks[i] x[first + i] - value|^2.
  template <std::size_t N>
  void Add(int first, const std::array<Block, N>& blocks, const Column& value, double weight) {
    static_assert(N <= kReach);
    for (std::size_t i = 0; i < N; ++i) {
      const std::size_t row = static_cast<std::size_t>(first) + i;
      b_.segment<Size>(Size * static_cast<Eigen::Index>(row)) +=
          weight * blocks[i].transpose() * value;
      for (std::size_t j = 0; j <= i; ++j)
        band_[row][i - j] += weight * blocks[i].transpose() * blocks[j];
    }
  }

  /// Adds weight * (third difference)^2 of the points.
  void AddSmoothing(double weight) {
    constexpr std::array<double, 4> kThirdDifference = {-1, 3, -3, 1};
    for (int k = 0; k + 3 < static_cast<int>(band_.size()); ++k)
      Add(k, kThirdDifference, Column::Zero(), weight);
  }

  /// One column per point.
  Eigen::Matrix<double, Size, Eigen::Dynamic> Solve() const {
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t row = 0; row < band_.size(); ++row) {
      for (std::size_t back = 0; back <= std::min<std::size_t>(row, kReach - 1); ++back) {
        for (int r = 0; r < Size; ++r) {
          for (int c = 0; c < Size; ++c) {
            const double value = band_[row][back](r, c);
            if (value == 0) continue;
            entries.emplace_back(
                static_cast<int>(row) * Size + r, static_cast<int>(row - back) * Size + c, value);
          }
        }
      }
    }
    Eigen::SparseMatrix<double> A(b_.size(), b_.size());
    A.setFromTriplets(entries.begin(), entries.end());
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower> solver(A);
    FACET_CHECK(solver.info() == Eigen::Success) << "the spline is not determined by its poses";
    const VectorXd x = solver.solve(b_);
    return x.reshaped(Size, x.size() / Size);
  }

 private:
  std::vector<std::array<Block, kReach>> band_;  // of each row of blocks, from the diagonal back
  VectorXd b_;
};

/// The matrix that multiplies a quaternion's x y z w by the pure quaternion of v from the right.
Eigen::Matrix4d RightProduct(const Vector3d& v) {
  Eigen::Matrix4d M;
  M << 0, v.z(), -v.y(), v.x(),  //
      -v.z(), 0, v.x(), v.y(),   //
      v.y(), -v.x(), 0, v.z(),   //
      -v.x(), -v.y(), -v.z(), 0;
  return M;
}

double MeanInterval(std::size_t count, Duration whole) {
  return ToSeconds(whole) / static_cast<double>(std::max<std::size_t>(2, count) - 1);
}

}  // namespace

/// Fits the control points of a spline whose knots are known.
class SplineTrajectory::LeastSquares {
 public:
  LeastSquares(SplineTrajectory& spline,
               std::span<const NavState> states,
               const SplineOptions& options)
      : spline_(spline), states_(states), smoothing_(options.smoothing) {
    FACET_CHECK(states.size() >= 2 && ToSeconds(states.back().t - states.front().t) >= 1.0)
        << states.size() << " poses are too few or too short a time";
    spline.begin_ = states.front().t;
    spline.end_ = states.back().t;
    const double duration = ToSeconds(spline.end_ - spline.begin_);
    num_intervals_ = std::max(1, static_cast<int>(std::ceil(duration / options.knot_interval_s)));
    spline.knot_interval_s_ = duration / num_intervals_;
    spline.control_points_.assign(static_cast<std::size_t>(num_points()), Coefficients::Zero());
  }

  void FitPoses() {
    SetPositions(PositionsOfPoses().Solve());
    SetRotations(RotationsOfPoses().Solve());
  }

  /// Rotations first, exactly: dq/dt = q w / 2 is linear in q. They say where the accelerometer
  /// points.
  void FitPosesAndImu(std::span<const ImuSample> imu, const ImuFitOptions& options) {
    const double share = MeanInterval(imu.size(), imu.back().t - imu.front().t) /
                         MeanInterval(states_.size(), states_.back().t - states_.front().t);
    FitRotations(imu, share * std::pow(options.rotation_time_s, 2));
    FitPositions(imu, share * std::pow(options.position_time_s, 4));
  }

 private:
  int num_points() const { return num_intervals_ + kDegree; }

  KnotPosition LocateAt(Timestamp t) const {
    return Locate(ToSeconds(t - spline_.begin_), spline_.knot_interval_s_, num_intervals_);
  }

  NormalEquations<3> PositionsOfPoses() const {
    NormalEquations<3> equations(num_points());
    for (const NavState& state : states_) {
      const KnotPosition at = LocateAt(state.t);
      equations.Add(at.interval, Basis<kDegree>(at.u), state.T_WB.p, 1);
    }
    equations.AddSmoothing(smoothing_);
    return equations;
  }

  NormalEquations<4> RotationsOfPoses() const {
    NormalEquations<4> equations(num_points());
    Vector4d previous = states_.front().T_WB.q.coeffs();
    for (const NavState& state : states_) {
      const Vector4d q = state.T_WB.q.coeffs();
      const double sign = q.dot(previous) < 0 ? -1.0 : 1.0;  // q and -q are the same rotation
      previous = sign * q;
      const KnotPosition at = LocateAt(state.t);
      equations.Add(at.interval, Basis<kDegree>(at.u), previous, 1);
    }
    equations.AddSmoothing(smoothing_);
    return equations;
  }

  /// Calls visit(sample, bias, place) for the samples within the time of the poses.
  template <class Visit>
  void VisitSamples(std::span<const ImuSample> imu, const Visit& visit) const {
    std::size_t next = 0;
    for (const ImuSample& sample : imu) {
      if (sample.t < spline_.begin_ || sample.t > spline_.end_) continue;
      while (next + 1 < states_.size() && states_[next + 1].t <= sample.t)
        ++next;
      visit(sample, states_[next].bias, LocateAt(sample.t));
    }
  }

  void FitRotations(std::span<const ImuSample> imu, double weight) {
    NormalEquations<4> equations = RotationsOfPoses();
    VisitSamples(imu, [&](const ImuSample& sample, const ImuBias& bias, const KnotPosition& at) {
      const auto value = Basis<kDegree>(at.u);
      const auto slope = DerivativeWeights<kDegree, 1>(at.u, spline_.knot_interval_s_);
      const Eigen::Matrix4d half_rate = RightProduct(0.5 * (sample.gyro - bias.b_g));
      std::array<Eigen::Matrix4d, kDegree + 1> blocks;
      for (std::size_t i = 0; i < blocks.size(); ++i)
        blocks[i] = slope[i] * Eigen::Matrix4d::Identity() - value[i] * half_rate;
      equations.Add(at.interval, blocks, Vector4d::Zero(), weight);
    });
    SetRotations(equations.Solve());
  }

  void FitPositions(std::span<const ImuSample> imu, double weight) {
    NormalEquations<3> equations = PositionsOfPoses();
    VisitSamples(imu, [&](const ImuSample& sample, const ImuBias& bias, const KnotPosition& at) {
      const Vector4d q = spline_.Evaluate(ToSeconds(sample.t - spline_.begin_))[0].tail<4>();
      const Vector3d a_W =
          Quaterniond(q).normalized() * (sample.accel - bias.b_a) + GravityInWorld();
      equations.Add(
          at.interval, DerivativeWeights<kDegree, 2>(at.u, spline_.knot_interval_s_), a_W, weight);
    });
    SetPositions(equations.Solve());
  }

  void SetPositions(const MatrixXd& x) {
    for (Eigen::Index i = 0; i < x.cols(); ++i)
      spline_.control_points_[static_cast<std::size_t>(i)].head<3>() = x.col(i);
  }
  void SetRotations(const MatrixXd& x) {
    for (Eigen::Index i = 0; i < x.cols(); ++i)
      spline_.control_points_[static_cast<std::size_t>(i)].tail<4>() = x.col(i);
  }

  SplineTrajectory& spline_;
  std::span<const NavState> states_;
  double smoothing_;
  int num_intervals_ = 0;
};

SplineTrajectory SplineTrajectory::Fit(std::span<const NavState> states,
                                       const SplineOptions& options) {
  SplineTrajectory spline;
  LeastSquares(spline, states, options).FitPoses();
  return spline;
}

SplineTrajectory SplineTrajectory::FitWithImu(std::span<const NavState> states,
                                              std::span<const ImuSample> imu,
                                              const ImuFitOptions& options) {
  SplineTrajectory spline;
  LeastSquares fit(spline, states, options.spline);
  if (imu.size() < 2)
    fit.FitPoses();
  else
    fit.FitPosesAndImu(imu, options);
  return spline;
}

SplineTrajectory SplineTrajectory::MovedBy(const SE3& T_NW) const {
  SplineTrajectory moved = *this;
  for (Coefficients& point : moved.control_points_) {
    const Vector3d p_W = point.head<3>();
    const Vector4d q_W = point.tail<4>();
    point << T_NW * p_W, (T_NW.q * Quaterniond(q_W)).coeffs();
  }
  return moved;
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
