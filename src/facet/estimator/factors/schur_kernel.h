// SPDX-License-Identifier: BSD-2-Clause
// The innermost loops of eliminating a landmark.
#pragma once

#include "facet/estimator/factors/lanes.h"

namespace facet {

/// h -= A B^T for a kRows x 3 matrix A and a kColumns x 3 matrix B (column-major, with so much
/// between two columns); h is a block of a column-major matrix with the given distance between
/// columns. Twice as fast as Eigen's product of this size. `first_row(c)`: of column c rows before
/// it do not count.
template <int kLanes, int kRows, int kStrideA, int kColumns, int kStrideB, class FirstRow>
inline void SubtractProduct(
    const double* A, const double* B, double* h, long column_stride, const FirstRow& first_row) {
  const double *A1 = A + kStrideA, *A2 = A1 + kStrideA, *B1 = B + kStrideB, *B2 = B1 + kStrideB;
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

/// Of a 6x3 matrix A, and the first kColumns rows of a matrix B of kStride.
template <int kLanes, int kColumns, int kStride = kColumns>
void SubtractOuterProduct(const double* A, const double* B, double* h, long column_stride) {
  SubtractProduct<kLanes, 6, 6, kColumns, kStride>(A, B, h, column_stride, [](int) { return 0; });
}

/// h -= A A^T for the first kRows rows of a matrix A of kStride; only the lower triangle of h is
/// complete.
template <int kLanes, int kRows, int kStride>
void SubtractSquare(const double* A, double* h, long column_stride) {
  SubtractProduct<kLanes, kRows, kStride, kRows, kStride>(
      A, A, h, column_stride, [](int c) { return c; });
}

}  // namespace facet
