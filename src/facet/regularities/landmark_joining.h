// SPDX-License-Identifier: BSD-2-Clause
// Which landmarks come to lie on planes.
#pragma once

#include <vector>

#include "facet/map/plane_assignments.h"
#include "facet/regularities/known_plane.h"
#include "facet/regularities/surface_face.h"

namespace facet {

/// A landmark joins a plane when two faces around it are on the plane, or half of them. Tentative
/// planes have no landmarks. `landmark_of_point`: see LandmarksOfVertices; `plane_of_face`: into
/// `planes`, -1: none.
void JoinLandmarks(const MapSnapshot& map,
                   const SurfaceFaces& faces,
                   const std::vector<int>& landmark_of_point,
                   const std::vector<int>& plane_of_face,
                   const std::vector<KnownPlane>& planes,
                   PlaneAssignments& out);

}  // namespace facet
