// SPDX-License-Identifier: BSD-2-Clause
// The innermost loops of eliminating a landmark.
#pragma once

#include "facet/estimator/factors/lanes.h"

namespace facet {

/// h -= A B^T for a kRows x 3 matrix A and a kColumns x 3 matrix B (column-major, packed); h is a
/// block of a column-major matrix with the given distance between columns. Twice as fast as Eigen's
/// product of this size. `first_row(c)`: of column c rows before it do not count.
template <int kLanes, int kRows, int kColumns, class FirstRow>
inline void SubtractProduct(
    const double* A, const double* B, double* h, long column_stride, const FirstRow& first_row) {
  const double *A1 = A + kRows, *A2 = A1 + kRows, *B1 = B + kColumns, *B2 = B1 + kColumns;
  for (int c = 0; c < kColumns; ++c) {
    double* const column = h + c * column_stride;
    OverLanes<kLanes, kRows>(first_row(c), [&]<int kNum>(int r) {
      Lanes<kNum> sum = Load<kNum>(column + r);
      sum -= Load<kNum>(A + r) * AllOf<kNum>(B[c]) + Load<kNum>(A1 + r) * AllOf<kNum>(B1[c]) +
             Load<kNum>(A2 + r) * AllOf<kNum>(B2[c]);
      Store<kNum>(sum, column + r);
    });
  }
}

/// Of a 6x3 matrix A.
template <int kLanes, int kColumns>
void SubtractOuterProduct(const double* A, const double* B, double* h, long column_stride) {
  SubtractProduct<kLanes, 6, kColumns>(A, B, h, column_stride, [](int) { return 0; });
}

/// h -= A A^T for a kRows x 3 matrix A; only the lower triangle of h is complete.
template <int kLanes, int kRows>
void SubtractSquare(const double* A, double* h, long column_stride) {
  SubtractProduct<kLanes, kRows, kRows>(A, A, h, column_stride, [](int c) { return c; });
}

}  // namespace facet
