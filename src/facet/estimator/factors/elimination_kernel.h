// SPDX-License-Identifier: BSD-2-Clause
// The innermost loops of eliminating a motion.
#pragma once

#include "facet/estimator/factors/lanes.h"

namespace facet {

/// Variables that are eliminated at once: those of a motion.
inline constexpr int kEliminated = 9;

/// Nine columns of a column-major matrix, with so much between two of them.
struct NineColumns {
  double* data;
  long stride;
  int num_rows;
};

/// X = X L^-T for a 9x9 lower triangle L (column-major) with the inverses of its diagonal.
template <int kLanes>
void SolveNineColumns(const double* L, const double* inverse_diagonal, const NineColumns& X) {
  const auto solve = [&]<int kNum>(int row) {
    Lanes<kNum> x[kEliminated];
#pragma GCC unroll 9
    for (int k = 0; k < kEliminated; ++k) {
      x[k] = Load<kNum>(X.data + k * X.stride + row);
#pragma GCC unroll 9
      for (int j = 0; j < k; ++j)
        x[k] -= x[j] * AllOf<kNum>(L[j * kEliminated + k]);
      x[k] *= AllOf<kNum>(inverse_diagonal[k]);
      Store<kNum>(x[k], X.data + k * X.stride + row);
    }
  };
  int row = 0;
  for (; row + kLanes <= X.num_rows; row += kLanes)
    solve.template operator()<kLanes>(row);
  for (; row < X.num_rows; ++row)
    solve.template operator()<1>(row);
}

/// kVectors times kNum rows of kColumns columns of h -= A B^T.
template <int kNum, int kVectors, int kColumns>
[[gnu::always_inline]] inline void SubtractTile(
    const double* a, long stride_a, const double* b, long stride_b, double* h, long stride_h) {
  Lanes<kNum> sum[kVectors][kColumns];
#pragma GCC unroll 9
  for (int k = 0; k < kEliminated; ++k) {
    Lanes<kNum> rows[kVectors];
    for (int v = 0; v < kVectors; ++v)
      rows[v] = Load<kNum>(a + k * stride_a + v * kNum);
    for (int c = 0; c < kColumns; ++c) {
      const Lanes<kNum> column = AllOf<kNum>(b[k * stride_b + c]);
      for (int v = 0; v < kVectors; ++v)
        sum[v][c] = k == 0 ? rows[v] * column : sum[v][c] + rows[v] * column;
    }
  }
  for (int c = 0; c < kColumns; ++c) {
    for (int v = 0; v < kVectors; ++v) {
      double* const to = h + c * stride_h + v * kNum;
      Store<kNum>(Load<kNum>(to) - sum[v][c], to);
    }
  }
}

/// The same for so many columns and all rows from `first_row` (rounded down to a whole step) on.
template <int kLanes, int kColumns>
[[gnu::always_inline]] inline void SubtractColumns(
    const NineColumns& A, const double* b, long stride_b, int first_row, double* h, long stride_h) {
  constexpr int kVectors = 2;
  int row = first_row / kLanes * kLanes;
  for (; row + kVectors * kLanes <= A.num_rows; row += kVectors * kLanes) {
    SubtractTile<kLanes, kVectors, kColumns>(
        A.data + row, A.stride, b, stride_b, h + row, stride_h);
  }
  for (; row + kLanes <= A.num_rows; row += kLanes)
    SubtractTile<kLanes, 1, kColumns>(A.data + row, A.stride, b, stride_b, h + row, stride_h);
  for (; row < A.num_rows; ++row)
    SubtractTile<1, 1, kColumns>(A.data + row, A.stride, b, stride_b, h + row, stride_h);
}

/// h -= A B^T; h has stride_h between two columns. If B is A only the lower triangle is complete.
/// Eigen's product of this depth needs another matrix besides.
template <int kLanes>
void SubtractNineColumns(const NineColumns& A, const NineColumns& B, double* h, long stride_h) {
  constexpr int kColumns = 3;
  const bool is_square = A.data == B.data;
  int column = 0;
  for (; column + kColumns <= B.num_rows; column += kColumns) {
    SubtractColumns<kLanes, kColumns>(
        A, B.data + column, B.stride, is_square ? column : 0, h + column * stride_h, stride_h);
  }
  for (; column < B.num_rows; ++column) {
    SubtractColumns<kLanes, 1>(
        A, B.data + column, B.stride, is_square ? column : 0, h + column * stride_h, stride_h);
  }
}

}  // namespace facet
