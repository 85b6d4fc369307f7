// SPDX-License-Identifier: BSD-2-Clause
#include "facet/plausibility/scale_check.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include <Eigen/Cholesky>

#include "facet/base/median.h"

namespace facet {
namespace {

// Keyframes nearer than this are left out: of two positions a millimetre apart no acceleration can
// be told. Later than that the gyroscope's errors count.
constexpr double kShortest_s = 0.15, kLongest_s = 1.0;
constexpr int kRowsPerLegs = 3;
// The least before anything is said, how often it is said anew, and after how many nothing more is
// to be learnt.
constexpr int kLeastLegs = 20, kLegsPerFit = 10, kMostLegs = 1000;
// Refusals: whoever has the units or axes wrong is told so by the gyroscope, which takes some
// seconds; and a run that has gone well for a minute is not refused any more.
constexpr int kLeastLegsForRefusal = 40, kMostLegsForRefusal = 300;
// Of the accelerometer [m/s^2].
constexpr double kBiasSigma = 0.5;
// Neighbours share a position, so their errors are not independent.
constexpr double kCorrelated = 1.5;
// The least that is worth telling (a calibrated accelerometer's own scale is off by some 0.3 %),
// and that makes a run useless.
constexpr double kLeastDoubt = 0.01, kLeastRefusal = 0.15, kSureSigmas = 2.8;
// Early fits have poses in them that were not settled: a doubt has to last.
constexpr int kDoubtsInARow = 3;
constexpr double kHuberWidth = 2, kSigmaPerMedian = 1.4826;
constexpr int kReweightings = 5;

}  // namespace

bool ScaleCheck::Scale::IsOff(double least, double sigmas) const {
  const double limit = std::max(least, sigmas * sigma);
  return low - 1 > limit || 1 - high > limit;
}

void ScaleCheck::AddImu(const ImuInterval& imu) {
  if (!second_) return;
  if (imu.samples.empty() || imu.has_hole || second_->imu.dt() > kLongest_s) {
    Break();
  } else {
    second_->imu.Integrate(imu.samples);
  }
}

ScaleCheck::Finding ScaleCheck::AddKeyframe(const NavState& state) {
  Finding finding = Finding::kNothing;
  if (static_cast<int>(rows_.size()) >= kRowsPerLegs * kMostLegs) return finding;
  if (second_) {
    if (second_->imu.dt() < kShortest_s) return finding;
    if (first_) AddRows(*first_, *second_, state);
    if (first_ && rows_.size() % (kRowsPerLegs * kLegsPerFit) == 0) finding = Judge();
    first_ = std::move(second_);
  }
  second_ = Leg{state, ImuPreintegration({state.bias.b_g, Vector3d::Zero()}, {})};
  return finding;
}

void ScaleCheck::Break() {
  first_.reset();
  second_.reset();
}

// From one leg to the next the mean velocity changes by s (g (T1 + T2) / 2 + a), where a is what
// the accelerometer says without gravity and bias, and s the scale: the velocity at the keyframe
// between them drops out.
void ScaleCheck::AddRows(const Leg& first, const Leg& second, const NavState& end) {
  const double T1 = first.imu.dt(), T2 = second.imu.dt();
  const Matrix3d R1 = first.begin.T_WB.R(), R2 = second.begin.T_WB.R();
  const Vector3d change =
      (end.T_WB.p - second.begin.T_WB.p) / T2 - (second.begin.T_WB.p - first.begin.T_WB.p) / T1;
  const Vector3d by_force =
      R1 * (first.imu.dv() - first.imu.dp() / T1) + R2 * (second.imu.dp() / T2);
  const auto by_bias = [](const ImuPreintegration& imu, int row) -> Matrix3d {
    return imu.BiasJacobian().block<3, 3>(row, 3);
  };
  const Matrix3d of_bias = R1 * (by_bias(first.imu, 6) - by_bias(first.imu, 3) / T1) +
                           R2 * (by_bias(second.imu, 3) / T2);
  for (int axis = 0; axis < 3; ++axis) {
    Row row;
    row.velocity = change(axis);
    row.force = by_force(axis);
    row.constants << 0.5 * (T1 + T2) * Vector3d::Unit(axis), of_bias.row(axis).transpose();
    rows_.push_back(row);
  }
}

// y = slope x + constants. Huber's loss in units of the residuals' own spread.
std::optional<ScaleCheck::Line> ScaleCheck::FitLine(double Row::*x, double Row::*y) const {
  constexpr int kSize = 1 + kNumConstants;
  std::vector<double> residuals(rows_.size()), sizes(rows_.size());
  double width = 0;
  Line line;
  for (int k = 0; k < kReweightings; ++k) {
    Matrix<kSize, kSize> H = Matrix<kSize, kSize>::Zero();
    Vector<kSize> b = Vector<kSize>::Zero(), a;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const double weight =
          width > 0 ? std::min(1.0, kHuberWidth * width / std::abs(residuals[i])) : 1.0;
      a << rows_[i].*x, rows_[i].constants;
      H += weight * a * a.transpose();
      b += weight * rows_[i].*y * a;
    }
    H.diagonal().tail<3>().array() += width * width / (kBiasSigma * kBiasSigma);
    const Eigen::LDLT<Matrix<kSize, kSize>> factor(H);
    if (factor.info() != Eigen::Success || !factor.isPositive()) return std::nullopt;
    const Vector<kSize> solution = factor.solve(b);
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      residuals[i] = rows_[i].*y - solution(0) * rows_[i].*x -
                     solution.tail<kNumConstants>().dot(rows_[i].constants);
      sizes[i] = std::abs(residuals[i]);
    }
    width = kSigmaPerMedian * Median(sizes).value_or(0);
    const double variance = factor.solve(Vector<kSize>::Unit(0))(0);
    line = {solution(0), kCorrelated * width * std::sqrt(std::max(variance, 0.0))};
  }
  if (!std::isfinite(line.slope) || !std::isfinite(line.sigma)) return std::nullopt;
  return line;
}

std::optional<ScaleCheck::Scale> ScaleCheck::Fit() const {
  const std::optional<Line> by_force = FitLine(&Row::force, &Row::velocity);
  const std::optional<Line> by_velocity = FitLine(&Row::velocity, &Row::force);
  if (!by_force || !by_velocity) return std::nullopt;
  // Both have the sign of the correlation. A negative one is nothing but noise, unless it is clear.
  const bool is_known = by_force->slope > 0 || by_force->slope < -kSureSigmas * by_force->sigma;
  if (!is_known || by_force->slope * by_velocity->slope <= 0) return std::nullopt;
  const double inverse = 1 / by_velocity->slope;
  Line low = *by_force, high{inverse, inverse * inverse * by_velocity->sigma};
  if (low.slope > high.slope) std::swap(low, high);
  const double sigma = low.slope > 1    ? low.sigma
                       : high.slope < 1 ? high.sigma
                                        : std::max(low.sigma, high.sigma);
  return Scale{low.slope, high.slope, sigma};
}

ScaleCheck::Finding ScaleCheck::Judge() {
  const int num_legs = static_cast<int>(rows_.size()) / kRowsPerLegs;
  if (num_legs < kLeastLegs) return Finding::kNothing;
  scale_ = Fit();
  if (!scale_) return Finding::kNothing;
  if (num_legs <= kMostLegsForRefusal && scale_->IsOff(kLeastRefusal, kSureSigmas))
    is_hopeless_ = true;
  if (is_hopeless_ && num_legs >= kLeastLegsForRefusal) return Finding::kRefusal;
  num_doubts_ = scale_->IsOff(kLeastDoubt, kSureSigmas) ? num_doubts_ + 1 : 0;
  if (has_doubted_ || num_doubts_ < kDoubtsInARow) return Finding::kNothing;
  has_doubted_ = true;
  return Finding::kDoubt;
}

std::string InWords(const ScaleCheck::Scale& scale) {
  if (scale.high < 0) {
    return "the accelerometer shows the opposite of what the cameras see: at rest it must measure "
           "+9.8 upwards; check the signs of a_RS_S in imu0/data.csv and T_BS, or T_cam_imu";
  }
  char text[400];
  std::snprintf(text,
                sizeof(text),
                "the stereo pair makes the world %.1f %% (1-sigma %.1f) too %s for the "
                "accelerometer: check the distance between the cameras (T_BS of both cameras, or "
                "T_cn_cnm1; metres), the focal lengths, and the accelerometer's scale",
                100 * std::abs(scale.value() - 1),
                100 * scale.sigma,
                scale.value() > 1 ? "large" : "small");
  return text;
}

}  // namespace facet
