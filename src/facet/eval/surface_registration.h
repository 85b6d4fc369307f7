// SPDX-License-Identifier: BSD-2-Clause
// Moves points onto a surface: point-to-plane ICP (Chen and Medioni, 1992).
#pragma once

#include <span>

#include "facet/eval/truth_surface.h"
#include "facet/geometry/se3.h"

namespace facet {

/// The small motion T_GM for which T_GM * p lies best on the surface, from the identity. Pairs
/// farther apart than a gate that closes from 0.3 m to 0.1 m are left out. Directions that the
/// surface leaves open (sliding along a single plane) stay as they are.
SE3 RegisterToSurface(std::span<const Vector3d> points_M, const TruthSurface& surface);

}  // namespace facet
