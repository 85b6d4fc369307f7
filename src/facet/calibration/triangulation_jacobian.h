// SPDX-License-Identifier: BSD-2-Clause
// How a point that is triangulated from a left and a right pixel moves with the calibration.
#pragma once

#include <optional>

#include "facet/calibration/rig_parameters.h"

namespace facet {

/// d p_C0 / d parameters, the pixels held: the ray is that of the left pixel, the distance the one
/// whose projection is nearest to the right pixel (TriangulateOnRay). `p_C0`: the point in the left
/// camera. Empty if a camera does not see it, or the right camera sees no distance in it.
std::optional<Matrix<3, kNumRigParameters>> TriangulationJacobian(const StereoRig& rig,
                                                                  const Vector3d& p_C0);

}  // namespace facet
