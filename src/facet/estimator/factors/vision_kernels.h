// SPDX-License-Identifier: BSD-2-Clause
// The inner loops of the back end, for the processor that the program runs on.
#pragma once

#include "facet/estimator/factors/elimination_kernel.h"
#include "facet/estimator/factors/lens_kernel.h"
#include "facet/estimator/factors/row_kernel.h"
#include "facet/estimator/factors/schur_kernel.h"

namespace facet {

/// Of the columns of lenses and stereo pair, with those of the lenses' modes or without.
struct LensKernels {
  /// AddLensProducts of a camera's two rows.
  void (*add_left)(const LensRow*, const VisionRow*, const LensProducts&);
  void (*add_right)(const LensRow*, const VisionRow*, const LensProducts&);
  /// SubtractOuterProduct of a pose with them, and SubtractSquare.
  void (*subtract_pose)(const double* A, const double* B, double* h, long column_stride);
  void (*subtract_square)(const double* A, double* h, long column_stride);
};

template <int kLanes, int kModes>
constexpr LensKernels MakeLensKernels() {
  constexpr int kColumns = kLensModes + 2 * kModes;
  return {AddLensProducts<kLanes, 2, kNumIntrinsics, kModes>,
          AddLensProducts<kLanes, 2, kNumRigParameters, 2 * kModes>,
          SubtractOuterProduct<kLanes, kColumns, kNumLensColumns>,
          SubtractSquare<kLanes, kColumns, kNumLensColumns>};
}

/// Each with the same results on every processor, bit by bit.
struct VisionKernels {
  void (*square_two_rows)(const VisionRow*, SquaredRows&);  ///< SquareRows
  void (*square_four_rows)(const VisionRow*, SquaredRows&);
  /// SubtractOuterProduct of two poses.
  void (*subtract_poses)(const double* A, const double* B, double* h, long column_stride);
  LensKernels with_modes, without_modes;
  /// Of a motion: SolveNineColumns and SubtractNineColumns.
  void (*solve_motion)(const double* L, const double* inverse_diagonal, const NineColumns& X);
  void (*subtract_motion)(const NineColumns& A,
                          const NineColumns& B,
                          double* h,
                          long column_stride);

  const LensKernels& lens(bool has_modes) const { return has_modes ? with_modes : without_modes; }
};

template <int kLanes>
constexpr VisionKernels MakeVisionKernels() {
  return {SquareRows<kLanes, 2>,
          SquareRows<kLanes, 4>,
          SubtractOuterProduct<kLanes, 6>,
          MakeLensKernels<kLanes, kNumLensModes>(),
          MakeLensKernels<kLanes, 0>(),
          SolveNineColumns<kLanes>,
          SubtractNineColumns<kLanes>};
}

/// Two numbers at a time: on every processor.
const VisionKernels& PairKernels();
/// Four at a time; null where this program was not built for it, or the processor cannot do it.
const VisionKernels* QuadKernels();

/// The faster one.
const VisionKernels& BestKernels();

}  // namespace facet
