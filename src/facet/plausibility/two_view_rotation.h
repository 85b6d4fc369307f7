// SPDX-License-Identifier: BSD-2-Clause
// How a camera turned between two images, from matched bearings alone: neither an IMU nor depths
// are asked.
#pragma once

#include <optional>
#include <span>

#include "facet/base/types.h"

namespace facet {

/// Unit vectors to the same point from the first and from the second place of the camera.
struct BearingPair {
  Vector3d first, second;
};

struct TwoViewRotation {
  Vector3d theta = Vector3d::Zero();  ///< Log of R_first_second [rad]
  /// Of theta; wide where other rotations with another direction of travel explain the pairs, too.
  Matrix3d covariance = Matrix3d::Identity();
};

/// Minimises the distances of the bearings from their epipolar planes over rotation and direction
/// of the translation, robustly: with a third of the pairs wrong it is still good to a few degrees,
/// but the covariance does not say so. Empty for fewer than 20 pairs. `sigma` is that of a bearing,
/// per axis [rad].
std::optional<TwoViewRotation> EstimateTwoViewRotation(std::span<const BearingPair> pairs,
                                                       double sigma);

}  // namespace facet
