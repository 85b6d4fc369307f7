// SPDX-License-Identifier: BSD-2-Clause
// Known planes as the support points of the newest keyframe show them (docs/math.md, section 9).
#pragma once

#include <vector>

#include "facet/map/plane_sighting.h"
#include "facet/mesh/search_mesh.h"
#include "facet/regularities/known_plane.h"
#include "facet/regularities/regularity_options.h"
#include "facet/regularities/surface_face.h"

namespace facet {

/// One for each plane of the estimator that is seen and that enough points determine, in the order
/// of `planes`. What counts are the support points that the keyframe itself has matched, which the
/// estimator does not have, where the surface of the plane is known, within three sigmas of it: a
/// narrower choice would make the plane confirm itself. Points whose faces are on other planes
/// alone (`plane_of_face`, -1: none) do not count. `mesh`, `faces` and `map` are of one keyframe.
std::vector<PlaneSighting> SightPlanes(const SearchMesh& mesh,
                                       const SurfaceFaces& faces,
                                       const std::vector<int>& plane_of_face,
                                       const std::vector<KnownPlane>& planes,
                                       const MapSnapshot& map,
                                       const SightingOptions& options);

}  // namespace facet
