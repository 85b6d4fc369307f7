// SPDX-License-Identifier: BSD-2-Clause
// Known planes as the support points of the newest keyframe show them (docs/math.md, section 9).
#pragma once

#include <span>
#include <vector>

#include "facet/map/plane_sighting.h"
#include "facet/regularities/known_plane.h"
#include "facet/regularities/regularity_options.h"
#include "facet/regularities/surface_face.h"

namespace facet {

/// One for each plane that enough points determine, in the order of `planes`. `plane_of_face` says
/// which plane a face is on (-1: none), `landmark_of_point` which landmark a point is (-1: none,
/// and only those count: the estimator has the others). `map` is of the same keyframe.
std::vector<PlaneSighting> SightPlanes(const SurfaceFaces& faces,
                                       std::span<const int> plane_of_face,
                                       std::span<const int> landmark_of_point,
                                       std::span<const KnownPlane> planes,
                                       const MapSnapshot& map,
                                       const SightingOptions& options);

}  // namespace facet
