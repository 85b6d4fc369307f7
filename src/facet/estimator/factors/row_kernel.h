// SPDX-License-Identifier: BSD-2-Clause
// Squares the rows of one observation: the other inner loop of the back end.
#pragma once

#include <cstring>

namespace facet {

/// One row of an observation: six columns of the pose, three of the landmark, the residual.
struct alignas(16) VisionRow {
  double pose[6];
  double landmark[3];
  double residual;
};

/// Normal equations of one observation, column-major.
struct alignas(16) SquaredRows {
  double H[36];  ///< pose-pose
  double W[18];  ///< pose-landmark
  double b[6];   ///< gradient of the pose
  double
      V[12];  ///< landmark-landmark in rows 0-2 of its 3 columns, gradient of the landmark in row 3
};

/// G = sum of row^T row. Every target with 16-byte vectors does two columns at a time; fixed order
/// of summation, so the same bits on every instruction set.
template <int kRows>
void SquareRows(const VisionRow* rows, SquaredRows& G) {
  using Pair = double __attribute__((vector_size(16)));
  constexpr int kPairs = 5, kPosePairs = 3;
  Pair pairs[kRows][kPairs];
  std::memcpy(pairs, rows, sizeof(pairs));
  const auto column = [&](int c, int first_pair, int last_pair, double* to) {
    Pair sum[kPairs] = {};
    for (int k = 0; k < kRows; ++k) {
      const double value = pairs[k][c / 2][c % 2];
      const Pair both = {value, value};
      for (int p = first_pair; p < last_pair; ++p)
        sum[p] += pairs[k][p] * both;
    }
    std::memcpy(
        to, sum + first_pair, sizeof(Pair) * static_cast<std::size_t>(last_pair - first_pair));
  };
  // The lower triangle and, in pairs, a little of the upper.
  for (int c = 0; c < 6; ++c)
    column(c, c / 2, kPosePairs, G.H + 6 * c + 2 * (c / 2));
  for (int c = 1; c < 6; ++c) {
    for (int r = 0; r < c; ++r)
      G.H[6 * c + r] = G.H[6 * r + c];
  }
  for (int c = 0; c < 3; ++c) {
    column(6 + c, 0, kPosePairs, G.W + 6 * c);
    column(6 + c, kPosePairs, kPairs, G.V + 4 * c);
  }
  column(9, 0, kPosePairs, G.b);
}

}  // namespace facet
