// SPDX-License-Identifier: BSD-2-Clause
// Squares the rows of one observation: the other inner loop of the back end.
#pragma once

#include "facet/estimator/factors/lanes.h"

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

/// G = sum of row^T row.
template <int kLanes, int kRows>
void SquareRows(const VisionRow* rows, SquaredRows& G) {
  static_assert(sizeof(VisionRow) == 10 * sizeof(double));
  const auto values = [&](int r) { return reinterpret_cast<const double*>(rows + r); };
  // The products of column c with kSize columns from `first` on.
  const auto column = [&]<int kSize>(int c, int first, double* to) {
    OverLanes<kLanes, kSize>(0, [&]<int kNum>(int i) {
      Lanes<kNum> sum = {};
      for (int r = 0; r < kRows; ++r)
        sum += Load<kNum>(values(r) + first + i) * AllOf<kNum>(values(r)[c]);
      Store<kNum>(sum, to + i);
    });
  };
  for (int c = 0; c < 6; ++c)
    column.template operator()<6>(c, 0, G.H + 6 * c);
  for (int c = 0; c < 3; ++c) {
    column.template operator()<6>(6 + c, 0, G.W + 6 * c);
    column.template operator()<4>(6 + c, 6, G.V + 4 * c);
  }
  column.template operator()<6>(9, 0, G.b);
}

}  // namespace facet
