// SPDX-License-Identifier: BSD-2-Clause
// How much an image shows, relative to EuRoC's 752 x 480 pixels with 458 px of focal length, for
// which options in pixels are written down.
#pragma once

#include "facet/camera/camera_model.h"

namespace facet {

/// The root of the number of pixels that lie in the lens's field of view, relative to EuRoC's: a
/// grid of cells that grow by it has as many cells.
double RelativeImageSide(const CameraModel& camera);

/// The same as an angle: how far the points of such a grid are apart on the sphere of rays,
/// relative to EuRoC's. Not changed by the resolution.
double RelativeViewAngle(const CameraModel& camera);

}  // namespace facet
