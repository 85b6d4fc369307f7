// SPDX-License-Identifier: BSD-2-Clause
// What the landmarks say of frames, planes and calibration, apart from all other factors. Mount and
// time offset move the cameras of a frame as its pose does, so their columns are made from those of
// the poses, after the elimination of the landmarks (docs/math.md, section 10.4).
#pragma once

#include <vector>

#include "facet/estimator/factors/landmark_block.h"
#include "facet/estimator/window/frame_geometry.h"
#include "facet/estimator/window/state_layout.h"

namespace facet {

/// For each frame what mount and time offset do to its pose, at the point of first estimates.
using MountJacobians = std::vector<Matrix<6, kNumMount>>;
MountJacobians MountJacobiansOf(const SlidingWindow& window, const FrameGeometry& geometry);

/// Adds what the sums say, in the columns of poses and calibration; lower triangle.
void AddLensSums(const LensSums& sums, const StateLayout& layout, MatrixXd& H, VectorXd& b);

/// `H` (lower triangle) and `b`: of the landmarks alone, with empty columns of mount and time
/// offset, which are filled.
void FillMountColumns(const MountJacobians& mounts,
                      const StateLayout& layout,
                      MatrixXd& H,
                      VectorXd& b);

/// What a step of mount and time offset does to the landmarks' residuals, as steps of the poses.
VectorXd WithMountAsPoses(const MountJacobians& mounts,
                          const StateLayout& layout,
                          const VectorXd& step);

}  // namespace facet
