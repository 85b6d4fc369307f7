// SPDX-License-Identifier: BSD-2-Clause
// The innermost loop of the back end, written so that any g++ or clang target vectorises it.
#pragma once

#include <cstring>

namespace facet {

/// h -= A B^T for a 6x3 matrix A and a kColumns x 3 matrix B (column-major, packed); h is a block
/// of a column-major matrix with the given distance between columns. Twice as fast as Eigen's
/// product of this size; fixed order of summation, so the same bits on every instruction set.
template <int kColumns>
void SubtractOuterProduct(const double* A, const double* B, double* h, long column_stride) {
  using Pair = double __attribute__((vector_size(16)));
  Pair a[9];
  std::memcpy(a, A, sizeof(a));
  const double *B1 = B + kColumns, *B2 = B1 + kColumns;
  for (int c = 0; c < kColumns; ++c) {
    const Pair b0 = {B[c], B[c]}, b1 = {B1[c], B1[c]}, b2 = {B2[c], B2[c]};
    Pair column[3];
    std::memcpy(column, h + c * column_stride, sizeof(column));
    for (int r = 0; r < 3; ++r)
      column[r] -= a[r] * b0 + a[3 + r] * b1 + a[6 + r] * b2;
    std::memcpy(h + c * column_stride, column, sizeof(column));
  }
}

/// h -= A A^T for a kRows x 3 matrix A, as above; only the lower triangle of h is complete.
template <int kRows>
void SubtractSquare(const double* A, double* h, long column_stride) {
  using Pair = double __attribute__((vector_size(16)));
  static_assert(kRows % 2 == 0);
  constexpr int kPairs = kRows / 2;
  Pair a[3 * kPairs];
  std::memcpy(a, A, sizeof(a));
  const double *A1 = A + kRows, *A2 = A1 + kRows;
  for (int c = 0; c < kRows; ++c) {
    const Pair b0 = {A[c], A[c]}, b1 = {A1[c], A1[c]}, b2 = {A2[c], A2[c]};
    double* const column = h + c * column_stride;
    for (int r = c / 2; r < kPairs; ++r) {
      Pair sum;
      std::memcpy(&sum, column + 2 * r, sizeof(sum));
      sum -= a[r] * b0 + a[kPairs + r] * b1 + a[2 * kPairs + r] * b2;
      std::memcpy(column + 2 * r, &sum, sizeof(sum));
    }
  }
}

}  // namespace facet
