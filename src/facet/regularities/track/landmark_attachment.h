// SPDX-License-Identifier: BSD-2-Clause
// Which landmarks are attached to planes.
#pragma once

#include <vector>

#include "facet/map/plane_assignments.h"
#include "facet/regularities/detect/surface_face.h"
#include "facet/regularities/track/tracked_plane.h"

namespace facet {

/// Attaches a landmark to a plane when two of the faces around it are on the plane, or half of
/// them. Tentative planes have no landmarks. `landmark_of_point`: see LandmarksOfVertices;
/// `plane_index_of_face`: into `planes`, -1: none.
void AttachLandmarks(const MapSnapshot& map,
                     const SurfaceFaces& faces,
                     const std::vector<int>& landmark_of_point,
                     const std::vector<int>& plane_index_of_face,
                     const std::vector<TrackedPlane>& planes,
                     PlaneAssignments& out);

}  // namespace facet
