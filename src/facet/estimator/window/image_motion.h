// SPDX-License-Identifier: BSD-2-Clause
// How a frame moves between its nominal stamp and when its image is really taken (docs/math.md,
// section 10.3).
#pragma once

#include "facet/estimator/window/imu_link.h"

namespace facet {

struct ImageMotion {
  Vector3d w_B = Vector3d::Zero();   ///< mean angular rate on the way [rad/s]
  Vector3d dv_B = Vector3d::Zero();  ///< mean velocity on the way less that at the stamp [m/s]
};

/// `x`: the state at the end of the interval of `link`; the image is taken `offset_s` later (before
/// it, if negative). Up to 2 ms the rates at the end are good enough, beyond that the last samples
/// of the interval say how they change.
ImageMotion MotionToImage(const ImuLink& link, const NavState& x, double offset_s);

}  // namespace facet
