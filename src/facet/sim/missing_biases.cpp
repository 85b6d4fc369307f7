// SPDX-License-Identifier: BSD-2-Clause
#include "facet/sim/missing_biases.h"

#include <algorithm>
#include <limits>

#include <Eigen/Cholesky>

#include "facet/sim/spline_trajectory.h"

namespace facet {
namespace {

// A spline through poses says nothing far from them.
constexpr Duration kNearPose{50'000'000};

// Usual sizes [m/s^2], and how well a second of samples tells a constant force.
constexpr double kSigmaBias = 0.2, kSigmaTilt = 0.05, kSigmaSecond = 0.05;

using BiasPart = Vector3d ImuBias::*;

/// Whether any state tells this bias; then all do.
bool Spread(BiasPart part, std::vector<NavState>& states) {
  const auto is_told = [&](const NavState& state) { return (state.bias.*part).allFinite(); };
  const auto first = std::find_if(states.begin(), states.end(), is_told);
  if (first == states.end()) return false;
  Vector3d last = first->bias.*part;
  for (NavState& state : states) {
    if (is_told(state)) last = state.bias.*part;
    state.bias.*part = last;
  }
  return true;
}

bool IsNearAPose(Timestamp t, const std::vector<NavState>& states) {
  const auto after = std::lower_bound(
      states.begin(), states.end(), t, [](const NavState& s, Timestamp at) { return s.t < at; });
  if (after != states.end() && after->t - t <= kNearPose) return true;
  return after != states.begin() && t - std::prev(after)->t <= kNearPose;
}

/// What each sample is more than the path explains, in one sum for the mean of the gyroscope and in
/// one for least squares over the accelerometer's bias [b_a, horizontal force in W].
class Excess {
 public:
  void Add(const ImuSample& sample, const SplineTrajectory& path) {
    const ImuSample ideal = path.IdealImuAt(sample.t);
    gyro_ += sample.gyro - ideal.gyro;
    const Matrix3d R_WB = path.At(sample.t).state.T_WB.R();
    Eigen::Matrix<double, 3, 5> A;
    A << R_WB, Matrix3d::Identity().leftCols<2>();
    information_ += A.transpose() * A;
    right_ += A.transpose() * (R_WB * (sample.accel - ideal.accel));
    first_ = count_ == 0 ? sample.t : first_;
    last_ = sample.t;
    ++count_;
  }

  bool empty() const { return count_ == 0; }
  Vector3d MeanGyro() const { return gyro_ / count_; }

  Vector3d AccelerometerBias() const {
    const double weight =
        ToSeconds(last_ - first_) / count_ / (kSigmaSecond * kSigmaSecond);  // of a sample
    Vector<5> prior;
    prior << Vector3d::Constant(1 / (kSigmaBias * kSigmaBias)),
        Vector2d::Constant(1 / (kSigmaTilt * kSigmaTilt));
    const Eigen::Matrix<double, 5, 5> H =
        weight * information_ + Eigen::Matrix<double, 5, 5>(prior.asDiagonal());
    const Vector<5> x = H.llt().solve(Vector<5>(weight * right_));
    return x.head<3>();
  }

 private:
  Vector3d gyro_ = Vector3d::Zero();
  Eigen::Matrix<double, 5, 5> information_ = Eigen::Matrix<double, 5, 5>::Zero();
  Vector<5> right_ = Vector<5>::Zero();
  double count_ = 0;
  Timestamp first_, last_;
};

}  // namespace

std::optional<ImuBias> FillInBiases(std::span<const ImuSample> imu, std::vector<NavState>& states) {
  const bool has_gyro = Spread(&ImuBias::b_g, states), has_accel = Spread(&ImuBias::b_a, states);
  if (has_gyro && has_accel) return std::nullopt;
  const SplineTrajectory path = SplineTrajectory::Fit(states);
  Excess excess;
  for (const ImuSample& sample : imu) {
    const bool is_covered = sample.t >= path.begin() && sample.t <= path.end();
    if (is_covered && IsNearAPose(sample.t, states)) excess.Add(sample, path);
  }
  const Vector3d none = Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  const Vector3d zero = Vector3d::Zero();
  ImuBias found{none, none};
  if (!has_gyro) found.b_g = excess.empty() ? zero : excess.MeanGyro();
  if (!has_accel) found.b_a = excess.empty() ? zero : excess.AccelerometerBias();
  for (NavState& state : states) {
    if (!has_gyro) state.bias.b_g = found.b_g;
    if (!has_accel) state.bias.b_a = found.b_a;
  }
  return found;
}

}  // namespace facet
