// SPDX-License-Identifier: BSD-2-Clause
// Where a patch of one camera lies in another one, and how it is deformed there.
#pragma once

#include <optional>

#include "facet/camera/camera_model.h"
#include "facet/frontend/patch_kernels.h"
#include "facet/geometry/se3.h"

namespace facet {

/// Image in `camera` of a patch at `ray` and inverse distance rho [1/m], where T_to_from maps from
/// the camera of the ray. The patch lies half-way between across the ray and parallel to that
/// camera's image. Distortion of both cameras is accounted for. Empty when the camera does not see
/// the point. The place may lie outside the image.
std::optional<PatchWarp> PredictWarp(const PixelBearing& ray,
                                     double rho,
                                     const SE3& T_to_from,
                                     const CameraModel& camera);

/// second o first.
PatchWarp ComposeLinear(const PatchWarp& second, const PatchWarp& first);

/// The inverse of the linear part, centred at (x, y); the identity if it cannot be inverted.
PatchWarp InverseAt(const PatchWarp& warp, float x, float y);

/// Root of the change of area.
float Scale(const PatchWarp& warp);

}  // namespace facet
