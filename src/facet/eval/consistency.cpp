// SPDX-License-Identifier: BSD-2-Clause
#include "facet/eval/consistency.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include "facet/eval/trajectory_error.h"
#include "facet/geometry/so3.h"

namespace facet {
namespace {

constexpr Duration kMaxTruthGap{100'000'000};
constexpr Duration kSettling{200'000'000};

// Sums of one part of the state.
class Accumulator {
 public:
  void Add(const Vector3d& error, const Vector3d& sigma) {
    if (!error.allFinite()) return;
    ++num_errors_;
    square_sum_ += error.squaredNorm();
    if (!sigma.allFinite() || !(sigma.array() > 0).all()) return;
    const Vector3d normalized = error.cwiseQuotient(sigma);
    ++num_normalized_;
    nees_.push_back(normalized.squaredNorm() / 3);
    nees_sum_ += normalized.squaredNorm();
    num_within_ += (normalized.array().abs() <= 2).count();
  }

  std::optional<NormalizedErrors> Result() const {
    if (num_errors_ == 0) return std::nullopt;
    NormalizedErrors result;
    result.num_states = num_normalized_;
    result.rmse = std::sqrt(square_sum_ / static_cast<double>(num_errors_));
    if (num_normalized_ > 0) {
      const double count = 3.0 * static_cast<double>(num_normalized_);
      result.nees = nees_sum_ / count;
      result.nees_median = Summarize(nees_).median;
      result.within_two_sigma = static_cast<double>(num_within_) / count;
    }
    return result;
  }

 private:
  std::size_t num_errors_ = 0, num_normalized_ = 0;
  std::vector<double> nees_;
  std::ptrdiff_t num_within_ = 0;
  double square_sum_ = 0, nees_sum_ = 0;
};

std::optional<NavState> TruthAt(std::span<const NavState> truth, Timestamp t) {
  const auto after = std::ranges::lower_bound(truth, t, {}, &NavState::t);
  if (after == truth.end()) return std::nullopt;
  if (after->t == t) return *after;
  if (after == truth.begin()) return std::nullopt;
  const NavState& b = *after;
  const NavState& a = *std::prev(after);
  if (b.t - a.t > kMaxTruthGap) return std::nullopt;
  const double s = ToSeconds(t - a.t) / ToSeconds(b.t - a.t);
  NavState state;
  state.t = t;
  state.T_WB = {a.T_WB.q.slerp(s, b.T_WB.q), (1 - s) * a.T_WB.p + s * b.T_WB.p};
  state.v_WB = (1 - s) * a.v_WB + s * b.v_WB;
  state.bias.b_g = (1 - s) * a.bias.b_g + s * b.bias.b_g;
  state.bias.b_a = (1 - s) * a.bias.b_a + s * b.bias.b_a;
  return state;
}

// T_WG by heading and position.
SE3 GaugeTransform(const SE3& T_WB, const SE3& T_GB) {
  const Matrix3d R = (T_WB.q * T_GB.q.conjugate()).toRotationMatrix();
  const double yaw = std::atan2(R(1, 0) - R(0, 1), R(0, 0) + R(1, 1));
  const Quaterniond q_WG(Eigen::AngleAxisd(yaw, Vector3d::UnitZ()));
  return {q_WG, T_WB.p - q_WG * T_GB.p};
}

}  // namespace

ConsistencyError EvaluateConsistency(std::span<const EstimatedState> estimate,
                                     std::span<const NavState> truth_G) {
  Accumulator position, orientation, velocity, gyro_bias, accel_bias;
  std::optional<SE3> T_WG;
  Timestamp first;
  for (const EstimatedState& e : estimate) {
    const auto truth = TruthAt(truth_G, e.state.t);
    if (!truth) continue;
    if (!T_WG) {
      T_WG = GaugeTransform(e.state.T_WB, truth->T_WB);
      first = e.state.t;
    }
    if (e.state.t - first < kSettling) continue;
    const SE3 T_WB = *T_WG * truth->T_WB;
    position.Add(e.state.T_WB.p - T_WB.p, e.sigma_p);
    orientation.Add(LogSO3(T_WB.q.conjugate() * e.state.T_WB.q), e.sigma_theta);
    velocity.Add(e.state.v_WB - T_WG->q * truth->v_WB, e.sigma_v);
    gyro_bias.Add(e.state.bias.b_g - truth->bias.b_g, e.sigma_b_g);
    accel_bias.Add(e.state.bias.b_a - truth->bias.b_a, e.sigma_b_a);
  }
  return {position.Result(),
          orientation.Result(),
          velocity.Result(),
          gyro_bias.Result(),
          accel_bias.Result()};
}

}  // namespace facet
