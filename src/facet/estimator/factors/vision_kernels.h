// SPDX-License-Identifier: BSD-2-Clause
// The inner loops of the back end, for the processor that the program runs on.
#pragma once

#include "facet/estimator/factors/lens_kernel.h"
#include "facet/estimator/factors/row_kernel.h"
#include "facet/estimator/factors/schur_kernel.h"

namespace facet {

/// Each with the same results on every processor, bit by bit.
struct VisionKernels {
  void (*square_two_rows)(const VisionRow*, SquaredRows&);  ///< SquareRows
  void (*square_four_rows)(const VisionRow*, SquaredRows&);
  /// AddLensProducts of a camera's two rows.
  void (*add_left_lens)(const LensRow*, const VisionRow*, const LensProducts&);
  void (*add_right_lens)(const LensRow*, const VisionRow*, const LensProducts&);
  /// SubtractOuterProduct of a pose with a pose and with the calibration, and SubtractSquare.
  void (*subtract_poses)(const double* A, const double* B, double* h, long column_stride);
  void (*subtract_pose_lens)(const double* A, const double* B, double* h, long column_stride);
  void (*subtract_lens)(const double* A, double* h, long column_stride);
};

template <int kLanes>
constexpr VisionKernels MakeVisionKernels() {
  return {SquareRows<kLanes, 2>,
          SquareRows<kLanes, 4>,
          AddLensProducts<kLanes, 2, kNumIntrinsics, kNumLensModes>,
          AddLensProducts<kLanes, 2, kNumRigParameters, 2 * kNumLensModes>,
          SubtractOuterProduct<kLanes, 6>,
          SubtractOuterProduct<kLanes, kNumLensColumns>,
          SubtractSquare<kLanes, kNumLensColumns>};
}

/// Two numbers at a time: on every processor.
const VisionKernels& PairKernels();
/// Four at a time; null where this program was not built for it, or the processor cannot do it.
const VisionKernels* QuadKernels();

/// The faster one.
const VisionKernels& BestKernels();

}  // namespace facet
