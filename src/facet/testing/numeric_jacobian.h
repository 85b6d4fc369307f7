// SPDX-License-Identifier: BSD-2-Clause
// Compares analytic Jacobians with central differences.
#pragma once

#include <gtest/gtest.h>

#include "facet/base/types.h"

namespace facet::testing {

/// d f / d x at x = 0 by central differences, for f: R^C -> R^R.
template <int R, int C, class F>
Matrix<R, C> NumericJacobian(const F& f, double step = 1e-6) {
  Matrix<R, C> J;
  for (int c = 0; c < C; ++c) {
    const Vector<C> d = step * Vector<C>::Unit(c);
    J.col(c) = (f(d) - f(Vector<C>(-d))) / (2 * step);
  }
  return J;
}

/// Asserts that J equals the numeric derivative of f at 0, relative to the size of J.
template <int R, int C, class F>
void ExpectJacobian(const Matrix<R, C>& J, const F& f, double tolerance, double step = 1e-6) {
  const Matrix<R, C> numeric = NumericJacobian<R, C>(f, step);
  const double scale = 1.0 + numeric.cwiseAbs().maxCoeff();
  EXPECT_LT((J - numeric).cwiseAbs().maxCoeff() / scale, tolerance) << "analytic\n"
                                                                    << J << "\nnumeric\n"
                                                                    << numeric;
}

}  // namespace facet::testing
