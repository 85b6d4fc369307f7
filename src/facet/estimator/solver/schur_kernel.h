// SPDX-License-Identifier: BSD-2-Clause
// The innermost loop of the back end, written so that any g++ or clang target vectorises it.
#pragma once

#include <cstring>

namespace facet {

/// h -= A B^T for 6x3 matrices A and B (column-major, packed); h is a 6x6 block of a column-major
/// matrix with the given distance between columns. Twice as fast as Eigen's product of this size;
/// fixed order of summation, so the same bits on every instruction set.
inline void SubtractOuterProduct(const double* A, const double* B, double* h, long column_stride) {
  using Pair = double __attribute__((vector_size(16)));
  Pair a[9];
  std::memcpy(a, A, sizeof(a));
  const double *B1 = B + 6, *B2 = B1 + 6;
  for (int c = 0; c < 6; ++c) {
    const Pair b0 = {B[c], B[c]}, b1 = {B1[c], B1[c]}, b2 = {B2[c], B2[c]};
    Pair column[3];
    std::memcpy(column, h + c * column_stride, sizeof(column));
    for (int r = 0; r < 3; ++r)
      column[r] -= a[r] * b0 + a[3 + r] * b1 + a[6 + r] * b2;
    std::memcpy(h + c * column_stride, column, sizeof(column));
  }
}

}  // namespace facet
