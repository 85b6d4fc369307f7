// SPDX-License-Identifier: BSD-2-Clause
#include "facet/plausibility/scale_check.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <span>
#include <type_traits>
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
constexpr double kSigmaOfKnown = 0.05;
// Early fits have poses in them that were not settled: a doubt has to last.
constexpr int kDoubtsInARow = 3;
constexpr double kHuberWidth = 2, kSigmaPerMedian = 1.4826;
constexpr int kReweightings = 5;
// Noise draws the factor of an axis from 1 towards 0, never beyond.
constexpr int kLeastLegsForAxes =
    60;  // where the gyroscope's axes are wrong, too, that is told first
constexpr double kLeastNegated = 0.2, kSureNegatedSigmas = 2.5;

template <int kNumSlopes>
struct Line {
  Vector<kNumSlopes> slope, sigma;
};

// y(row) = slope x(row) + constants. Huber's loss in units of the residuals' own spread.
template <int kNumSlopes, class Rows, class X, class Y>
std::optional<Line<kNumSlopes>> FitLine(const Rows& rows, const X& x, const Y& y) {
  constexpr int kNumConstants = std::decay_t<decltype(rows.front().constants)>::SizeAtCompileTime;
  constexpr int kSize = kNumSlopes + kNumConstants;
  std::vector<double> residuals(rows.size()), sizes(rows.size());
  double width = 0;
  Line<kNumSlopes> line;
  for (int k = 0; k < kReweightings; ++k) {
    Matrix<kSize, kSize> H = Matrix<kSize, kSize>::Zero();
    Vector<kSize> b = Vector<kSize>::Zero(), a;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const double weight =
          width > 0 ? std::min(1.0, kHuberWidth * width / std::abs(residuals[i])) : 1.0;
      a << x(rows[i]), rows[i].constants;
      H += weight * a * a.transpose();
      b += weight * y(rows[i]) * a;
    }
    H.diagonal().template tail<3>().array() += width * width / (kBiasSigma * kBiasSigma);
    const Eigen::LDLT<Matrix<kSize, kSize>> factor(H);
    if (factor.info() != Eigen::Success || !factor.isPositive()) return std::nullopt;
    const Vector<kSize> solution = factor.solve(b);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      a << x(rows[i]), rows[i].constants;
      residuals[i] = y(rows[i]) - solution.dot(a);
      sizes[i] = std::abs(residuals[i]);
    }
    width = kSigmaPerMedian * Median(sizes).value_or(0);
    line.slope = solution.template head<kNumSlopes>();
    for (int j = 0; j < kNumSlopes; ++j) {
      const double variance = factor.solve(Vector<kSize>::Unit(j))(j);
      line.sigma(j) = kCorrelated * width * std::sqrt(std::max(variance, 0.0));
    }
  }
  if (!line.slope.allFinite() || !line.sigma.allFinite()) return std::nullopt;
  return line;
}

}  // namespace

bool ScaleCheck::Scale::IsOff(double least, double sigmas) const {
  const double limit = std::max(least, sigmas * sigma);
  return low - 1 > limit || 1 - high > limit;
}

void ScaleCheck::AddImu(const ImuInterval& imu) {
  if (!second_) return;
  if (imu.samples.empty() || imu.has_hole || second_->imu.dt_s() > kLongest_s) {
    Break();
  } else {
    second_->imu.Integrate(imu.samples);
  }
}

ScaleCheck::Finding ScaleCheck::AddKeyframe(const NavState& state) {
  Finding finding = Finding::kNothing;
  if (static_cast<int>(rows_.size() - num_rows_before_) >= kRowsPerLegs * kMostLegs) return finding;
  if (second_) {
    if (second_->imu.dt_s() < kShortest_s) return finding;
    if (first_) AddRows(*first_, *second_, state);
    if (first_ && rows_.size() % (kRowsPerLegs * kLegsPerFit) == 0) finding = Judge();
    first_ = std::move(second_);
  }
  second_ = Leg{state, ForceIntegral(state.bias.b_g)};
  return finding;
}

void ScaleCheck::Break() {
  first_.reset();
  second_.reset();
}

void ScaleCheck::WorldHasChanged() {
  Break();
  num_rows_before_ = rows_.size();
  scale_.reset();
  num_doubts_ = 0;
  has_doubted_ = is_hopeless_ = false;
  is_accel_trusted_ = true;
}

// From one leg to the next the mean velocity changes by s (g (T1 + T2) / 2 + a), where a is what
// the accelerometer says without gravity and bias, and s the scale: the velocity at the keyframe
// between them drops out.
void ScaleCheck::AddRows(const Leg& first, const Leg& second, const NavState& end) {
  const double T1 = first.imu.dt_s(), T2 = second.imu.dt_s();
  const Matrix3d R1 = first.begin.T_WB.R(), R2 = second.begin.T_WB.R();
  const Vector3d change =
      (end.T_WB.p - second.begin.T_WB.p) / T2 - (second.begin.T_WB.p - first.begin.T_WB.p) / T1;
  const auto from_leg_to_leg = [&](const ForceIntegral::ByAxis& a,
                                   const ForceIntegral::ByAxis& b) -> Matrix3d {
    return R1 * (a.velocity - a.displacement / T1) + R2 * (b.displacement / T2);
  };
  const Matrix3d by_axis = from_leg_to_leg(first.imu.measured(), second.imu.measured());
  const Matrix3d of_bias = from_leg_to_leg(first.imu.constant(), second.imu.constant());
  for (int axis = 0; axis < 3; ++axis) {
    Row row;
    row.velocity = change(axis);
    row.force_by_axis = by_axis.row(axis).transpose();
    row.constants << 0.5 * (T1 + T2) * Vector3d::Unit(axis), of_bias.row(axis).transpose();
    rows_.push_back(row);
  }
}

std::optional<ScaleCheck::Scale> ScaleCheck::Fit() const {
  const auto force = [](const Row& row) { return row.force_by_axis.sum(); };
  const auto velocity = [](const Row& row) { return row.velocity; };
  const auto rows = std::span(rows_).subspan(num_rows_before_);
  const auto by_force = FitLine<1>(rows, force, velocity);
  const auto by_velocity = FitLine<1>(rows, velocity, force);
  if (!by_force || !by_velocity) return std::nullopt;
  struct Bound {
    double slope, sigma;
  };
  Bound low{by_force->slope(0), by_force->sigma(0)};
  // Both have the sign of the correlation. A negative one is nothing but noise, unless it is clear.
  const bool is_known = low.slope > 0 || low.slope < -kSureSigmas * low.sigma;
  if (!is_known || low.slope * by_velocity->slope(0) <= 0) return std::nullopt;
  const double inverse = 1 / by_velocity->slope(0);
  Bound high{inverse, inverse * inverse * by_velocity->sigma(0)};
  if (low.slope > high.slope) std::swap(low, high);
  const double sigma = low.slope > 1    ? low.sigma
                       : high.slope < 1 ? high.sigma
                                        : std::max(low.sigma, high.sigma);
  return Scale{low.slope, high.slope, sigma};
}

std::string ScaleCheck::FindNegatedAxes() const {
  const auto line = FitLine<3>(
      std::span(rows_),
      [](const Row& row) { return row.force_by_axis; },
      [](const Row& row) { return row.velocity; });
  std::string axes;
  for (int k = 0; line && k < 3; ++k) {
    if (line->slope(k) < -std::max(kLeastNegated, kSureNegatedSigmas * line->sigma(k)))
      axes += "xyz"[k];
  }
  return axes;
}

ScaleCheck::Finding ScaleCheck::Judge() {
  const int num_all_legs = static_cast<int>(rows_.size()) / kRowsPerLegs;
  if (num_all_legs >= kLeastLegs && num_all_legs <= kMostLegsForRefusal) {
    // What was clear once stays so: with a wrong accelerometer the poses become worse and worse.
    if (negated_axes_.empty()) negated_axes_ = FindNegatedAxes();
    if (!negated_axes_.empty() && num_all_legs >= kLeastLegsForAxes)
      return Finding::kAxesTheOtherWay;
  }
  const int num_legs = num_all_legs - static_cast<int>(num_rows_before_) / kRowsPerLegs;
  if (num_legs < kLeastLegs) return Finding::kNothing;
  scale_ = Fit();
  if (!scale_) return Finding::kNothing;
  // Whatever changes after the size was right once is no calibration.
  if (scale_->sigma < kSigmaOfKnown && !scale_->IsOff(kLeastRefusal, 0)) was_right_ = true;
  const bool is_useless = !was_right_ && num_all_legs <= kMostLegsForRefusal &&
                          scale_->IsOff(kLeastRefusal, kSureSigmas);
  // An estimator gives way to a wrong size, so what was clear once stays so; but not what an
  // accelerometer said whose bias was running away.
  if (is_useless && is_accel_trusted_) is_hopeless_ = true;
  if ((is_useless || is_hopeless_) && num_legs >= kLeastLegsForRefusal) return Finding::kRefusal;
  num_doubts_ = scale_->IsOff(kLeastDoubt, kSureSigmas) ? num_doubts_ + 1 : 0;
  if (has_doubted_ || num_doubts_ < kDoubtsInARow) return Finding::kNothing;
  has_doubted_ = true;
  return Finding::kDoubt;
}

std::string NegatedAxesInWords(const std::string& axes) {
  std::string what = "the accelerometer shows";
  if (axes.size() < 3) {
    what = axes.size() == 1 ? "an axis of the accelerometer, " : "two axes of the accelerometer, ";
    for (std::size_t k = 0; k < axes.size(); ++k)
      what += std::string(k > 0 ? " and " : "") + axes[k];
    what += axes.size() == 1 ? ", shows" : ", show";
  }
  return what +
         " the opposite of what the cameras see: at rest it must measure +9.8 upwards; check the "
         "signs of a_RS_S in imu0/data.csv and T_BS, or T_cam_imu";
}

std::string InWords(const ScaleCheck::Scale& scale) {
  if (scale.high < 0) return NegatedAxesInWords("xyz");
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
