// SPDX-License-Identifier: BSD-2-Clause
// Plane regions of any orientation, grown from face to face.
#pragma once

#include <span>
#include <vector>

#include "facet/regularities/detect/surface_face.h"

namespace facet {

/// Connected regions of the pool's faces whose normals agree with the region's and whose corners
/// lie near its plane; at least min_area_m2 large, largest first. The planes are rough:
/// area-weighted mean normal through the mean centre.
std::vector<Plane> GrowRegions(const SurfaceFaces& faces,
                               std::span<const int> pool,
                               double min_area_m2);

}  // namespace facet
