// SPDX-License-Identifier: BSD-2-Clause
// Where a patch of one camera lies in another one, and how it is deformed there.
#pragma once

#include <optional>

#include "facet/camera/camera_model.h"
#include "facet/frontend/patch_kernels.h"
#include "facet/geometry/se3.h"

namespace facet {

/// Image of a fronto-parallel patch at `ray` with inverse depth rho [1/m] in `camera`, where
/// T_to_from maps from the camera of the ray. Distortion of both cameras is accounted for. Empty
/// when the point is not in front of the camera. The place may lie outside the image.
std::optional<PatchWarp> PredictWarp(const UndistortedPoint& ray,
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
