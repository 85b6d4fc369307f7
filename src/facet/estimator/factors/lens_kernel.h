// SPDX-License-Identifier: BSD-2-Clause
// Products with the columns of lenses and stereo pair: the inner loop of estimating the
// calibration.
#pragma once

#include "facet/camera/rig_columns.h"
#include "facet/estimator/factors/row_kernel.h"

namespace facet {

/// The columns of lenses and stereo pair that belong to a VisionRow.
struct alignas(16) LensRow {
  double k[kNumLensColumns];
};

/// Where the products of rows are added up; all column-major, with kNumLensColumns rows.
struct LensProducts {
  double* H;         ///< calibration-calibration, kNumLensColumns columns: only the lower triangle
                     ///< is complete
  double* pose;      ///< calibration-pose, 6 columns
  double* landmark;  ///< calibration-landmark, 3 columns
  double* b;         ///< gradient
};

/// column += sum over the rows of the columns kFirst to kEnd of its calibration times its factor,
/// from row `first` of the column on.
template <int kLanes, int kRows, int kFirst, int kEnd>
inline void AddLensColumns(const LensRow* lens,
                           const double (&factors)[kRows],
                           int first,
                           double* column) {
  OverLanes<kLanes, kEnd - kFirst>(first > kFirst ? first - kFirst : 0, [&]<int kNum>(int i) {
    Lanes<kNum> sum = Load<kNum>(column + kFirst + i);
    for (int r = 0; r < kRows; ++r)
      sum += Load<kNum>(lens[r].k + kFirst + i) * AllOf<kNum>(factors[r]);
    Store<kNum>(sum, column + kFirst + i);
  });
}

/// Adds sum of lens^T (lens, row) over the rows of one camera. Of the rows' calibration only the
/// first kParameters parameters and the first kModes modes are not zero.
template <int kLanes, int kRows, int kParameters, int kModes>
void AddLensProducts(const LensRow* lens, const VisionRow* rows, const LensProducts& to) {
  constexpr int kEnd = kLensModes + kModes;
  const auto add = [&](auto value_of_row, int first, double* column) {
    double factors[kRows];
    for (int r = 0; r < kRows; ++r)
      factors[r] = value_of_row(r);
    if constexpr (kParameters == kLensModes) {
      AddLensColumns<kLanes, kRows, 0, kEnd>(lens, factors, first, column);
    } else {
      AddLensColumns<kLanes, kRows, 0, kParameters>(lens, factors, first, column);
      AddLensColumns<kLanes, kRows, kLensModes, kEnd>(lens, factors, first, column);
    }
  };
  const auto add_calibration = [&](int c) {
    add([&](int r) { return lens[r].k[c]; }, c, to.H + c * kNumLensColumns);
  };
  for (int c = 0; c < kParameters; ++c)
    add_calibration(c);
  for (int c = kLensModes; c < kEnd; ++c)
    add_calibration(c);
  for (int c = 0; c < 6; ++c)
    add([&](int r) { return rows[r].pose[c]; }, 0, to.pose + c * kNumLensColumns);
  for (int c = 0; c < 3; ++c)
    add([&](int r) { return rows[r].landmark[c]; }, 0, to.landmark + c * kNumLensColumns);
  add([&](int r) { return rows[r].residual; }, 0, to.b);
}

}  // namespace facet
