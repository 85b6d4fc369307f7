// SPDX-License-Identifier: BSD-2-Clause
// Products with the columns of lenses and stereo pair: the inner loop of estimating the
// calibration.
#pragma once

#include <cstring>

#include "facet/calibration/rig_parameters.h"
#include "facet/estimator/factors/row_kernel.h"

namespace facet {

/// The columns of lenses and stereo pair that belong to a VisionRow.
struct alignas(16) LensRow {
  double k[kNumRigParameters];
};

/// Where the products of rows are added up; all column-major, with kNumRigParameters rows.
struct LensProducts {
  double* H;     ///< calibration-calibration, kNumRigParameters columns: only the lower triangle
                 ///< is complete
  double* pose;  ///< calibration-pose, 6 columns
  double* landmark;  ///< calibration-landmark, 3 columns
  double* b;         ///< gradient
};

/// Adds sum of lens^T (lens, row) over the rows of one camera. Only the first kColumns of the rows'
/// calibration are not zero. Fixed order of summation, as in SquareRows.
template <int kRows, int kColumns>
void AddLensProducts(const LensRow* lens, const VisionRow* rows, const LensProducts& to) {
  using Pair = double __attribute__((vector_size(16)));
  static_assert(kColumns % 2 == 0 && kNumRigParameters % 2 == 0);
  constexpr int kPairs = kColumns / 2;
  Pair pairs[kRows][kPairs];
  for (int r = 0; r < kRows; ++r)
    std::memcpy(pairs[r], lens[r].k, sizeof(pairs[r]));
  const auto add = [&](const double(&factors)[kRows], int first_pair, double* column) {
    Pair both[kRows];
    for (int r = 0; r < kRows; ++r)
      both[r] = Pair{factors[r], factors[r]};
    for (int p = first_pair; p < kPairs; ++p) {
      Pair sum;
      std::memcpy(&sum, column + 2 * p, sizeof(sum));
      for (int r = 0; r < kRows; ++r)
        sum += pairs[r][p] * both[r];
      std::memcpy(column + 2 * p, &sum, sizeof(sum));
    }
  };
  const auto add_column = [&](auto value_of_row, int first_pair, double* column) {
    double factors[kRows];
    for (int r = 0; r < kRows; ++r)
      factors[r] = value_of_row(r);
    add(factors, first_pair, column);
  };
  for (int c = 0; c < kColumns; ++c)
    add_column([&](int r) { return lens[r].k[c]; }, c / 2, to.H + c * kNumRigParameters);
  for (int c = 0; c < 6; ++c)
    add_column([&](int r) { return rows[r].pose[c]; }, 0, to.pose + c * kNumRigParameters);
  for (int c = 0; c < 3; ++c)
    add_column([&](int r) { return rows[r].landmark[c]; }, 0, to.landmark + c * kNumRigParameters);
  add_column([&](int r) { return rows[r].residual; }, 0, to.b);
}

}  // namespace facet
