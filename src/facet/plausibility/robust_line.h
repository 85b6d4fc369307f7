// SPDX-License-Identifier: BSD-2-Clause
// The factor between two things that were measured together, one of which has constants in it that
// nobody knows (biases, gravity), among outliers.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>

#include "facet/base/median.h"
#include "facet/base/types.h"

namespace facet {

/// What is known of such a fit beforehand.
struct LineNoise {
  double bias_sigma = 1;  ///< of the last three constants, before any measurement
  double correlated = 1;  ///< by what sigmas are larger than those of independent rows
};

template <int kNumSlopes>
struct Line {
  Vector<kNumSlopes> slope, sigma;
};

/// y(row) = slope x(row) + row.constants times unknowns; empty where they cannot be told. Huber's
/// loss in units of the residuals' own spread.
template <int kNumSlopes, class Rows, class X, class Y>
std::optional<Line<kNumSlopes>> FitLine(const Rows& rows,
                                        const X& x,
                                        const Y& y,
                                        const LineNoise& noise) {
  constexpr double kHuberWidth = 2, kSigmaPerMedian = 1.4826;
  constexpr int kReweightings = 5;
  constexpr int kNumConstants = std::decay_t<decltype(rows.front().constants)>::SizeAtCompileTime;
  static_assert(kNumConstants >= 3, "the last three are biases");
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
    H.diagonal().template tail<3>().array() +=
        width * width / (noise.bias_sigma * noise.bias_sigma);
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
      line.sigma(j) = noise.correlated * width * std::sqrt(std::max(variance, 0.0));
    }
  }
  if (!line.slope.allFinite() || !line.sigma.allFinite()) return std::nullopt;
  return line;
}

/// A factor of which noise of the one side draws one estimate towards zero, and noise of the other
/// side another one towards infinity. The truth is between them.
struct FactorBounds {
  double low = 1, high = 1;
  double sigma = 0;  ///< of the one that is nearer to 1

  double value() const { return 0.5 * (low + high); }
  /// From 1 by at least so much, and for sure. Where there is more noise than anything in common,
  /// nothing is.
  bool IsOff(double least, double sigmas) const {
    const double limit = std::max(least, sigmas * sigma);
    return IsOneThing() && (low - 1 > limit || 1 - high > limit);
  }
  /// Most of what each side shows is seen by the other side, too.
  bool IsOneThing() const {
    const double a = std::abs(low), b = std::abs(high);
    return std::min(a, b) > 0.25 * std::max(a, b);
  }
};

/// y(row) = factor x(row) + constants, as above; empty also where both are nothing but noise.
template <class Rows, class X, class Y>
std::optional<FactorBounds> FitFactor(const Rows& rows,
                                      const X& x,
                                      const Y& y,
                                      const LineNoise& noise) {
  constexpr double kSureSigmas = 2.8;
  const auto by_x = FitLine<1>(rows, x, y, noise), by_y = FitLine<1>(rows, y, x, noise);
  if (!by_x || !by_y) return std::nullopt;
  struct Bound {
    double slope, sigma;
  };
  Bound low{by_x->slope(0), by_x->sigma(0)};
  // Both have the sign of the correlation, which is nothing but noise unless it is clear.
  const bool is_known = std::abs(low.slope) > kSureSigmas * low.sigma;
  if (!is_known || low.slope * by_y->slope(0) <= 0) return std::nullopt;
  const double inverse = 1 / by_y->slope(0);
  Bound high{inverse, inverse * inverse * by_y->sigma(0)};
  if (low.slope > high.slope) std::swap(low, high);
  const double sigma = low.slope > 1    ? low.sigma
                       : high.slope < 1 ? high.sigma
                                        : std::max(low.sigma, high.sigma);
  return FactorBounds{low.slope, high.slope, sigma};
}

}  // namespace facet
