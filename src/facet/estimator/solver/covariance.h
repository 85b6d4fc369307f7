// SPDX-License-Identifier: BSD-2-Clause
// Covariances and information of the variables of a solved window.
#pragma once

#include <vector>

#include "facet/estimator/solver/reduced_system.h"

namespace facet {

/// Marginal covariance of the newest frame, which must have motion: theta p v b_g b_a
/// (docs/math.md, equation (4.6)). The damping of the last Solve counts as information.
Matrix<15, 15> NewestFrameCovariance(const ReducedSystem& reduced, const StateLayout& layout);

/// Joint covariance of the newest pose and each plane: theta p, two tangent directions, offset.
std::vector<Matrix<9, 9>> PlaneCovariances(const ReducedSystem& reduced, const StateLayout& layout);

/// Of the clock of the cameras: with the newest frame (theta p v b_g b_a), and its variance.
struct ClockCovariance {
  Vector<15> with_newest = Vector<15>::Zero();
  double variance = 0;
};

/// Both need a calibration among the variables.
ClockCovariance NewestFrameWithClock(const ReducedSystem& reduced, const StateLayout& layout);
CalibrationMatrix CalibrationCovariance(const ReducedSystem& reduced, const StateLayout& layout);

/// What landmarks and measurements say about each plane, poses given: information on two tangent
/// directions and offset. The landmarks must have been eliminated (ReducedSystem::Solve).
std::vector<Matrix3d> PlaneInformation(const LinearizedWindow& linear);

}  // namespace facet
