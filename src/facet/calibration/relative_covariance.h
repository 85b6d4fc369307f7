// SPDX-License-Identifier: BSD-2-Clause
// What is left of a covariance, direction by direction.
#pragma once

#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "facet/base/types.h"

namespace facet {

/// Independent directions of two covariances of the same parameters, which may have different
/// units: along each of them the variance is 1 before and `shares()` after. `Square`: MatrixXd or a
/// matrix of fixed size.
template <class Square>
class RelativeCovariance {
 public:
  using Values = Eigen::Matrix<double, Square::RowsAtCompileTime, 1>;

  /// Empty where `before` is not positive definite, or something is not finite.
  static std::optional<RelativeCovariance> Of(const Square& before, const Square& after) {
    RelativeCovariance relative;
    relative.sigma_ = before.diagonal().cwiseSqrt();
    relative.inverse_sigma_ = relative.sigma_.cwiseInverse();
    relative.root_.compute(relative.Scaled(before));
    if (relative.root_.info() != Eigen::Success) return std::nullopt;
    Square whitened = relative.Scaled(after);
    relative.root_.matrixL().solveInPlace(whitened);
    whitened.transposeInPlace();
    relative.root_.matrixL().solveInPlace(whitened);
    if (!whitened.allFinite()) return std::nullopt;
    relative.solver_.compute(whitened);
    if (relative.solver_.info() != Eigen::Success) return std::nullopt;
    return relative;
  }

  /// Rising.
  const Values& shares() const { return solver_.eigenvalues(); }

  /// A deviation in these directions.
  Values Along(const Values& deviation) const {
    Values whitened = inverse_sigma_.cwiseProduct(deviation);
    root_.matrixL().solveInPlace(whitened);
    return solver_.eigenvectors().transpose() * whitened;
  }

  /// The covariance that has these shares instead.
  Square WithShares(const Values& shares) const {
    const Square axes = sigma_.asDiagonal() * (root_.matrixL() * solver_.eigenvectors());
    return axes * shares.asDiagonal() * axes.transpose();
  }

 private:
  RelativeCovariance() = default;

  Square Scaled(const Square& covariance) const {
    return inverse_sigma_.asDiagonal() * covariance * inverse_sigma_.asDiagonal();
  }

  Values sigma_, inverse_sigma_;
  Eigen::LLT<Square> root_;
  Eigen::SelfAdjointEigenSolver<Square> solver_;
};

}  // namespace facet
