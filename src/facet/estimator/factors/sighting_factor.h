// SPDX-License-Identifier: BSD-2-Clause
// Rows of the sightings of planes (docs/math.md, section 9): what one keyframe measured of a plane
// as a whole. They touch that keyframe's pose and the plane, and no landmark.
#pragma once

#include "facet/estimator/window/sliding_window.h"

namespace facet {

/// Residual and Jacobians of one sighting, whitened and weighted.
struct SightingRows {
  Vector3d r = Vector3d::Zero();  ///< distance at the centre, slopes
  Matrix<3, 6> J_pose = Matrix<3, 6>::Zero();
  Matrix3d J_plane = Matrix3d::Zero();  ///< two directions, offset
  double cost = 0;
};

/// Whitened residual of a plane and the frame that sighted it.
Vector3d SightingError(const PlaneSighting& sighting,
                       const WindowPlane& plane,
                       const WindowFrame& frame);

/// Residual at the estimate, Jacobians at the linearisation points. Sightings beyond `huber_sigma`
/// (norm of the whitened residual) grow linearly.
SightingRows LinearizeSighting(const PlaneSighting& sighting,
                               const WindowPlane& plane,
                               const WindowFrame& frame,
                               double huber_sigma);

}  // namespace facet
