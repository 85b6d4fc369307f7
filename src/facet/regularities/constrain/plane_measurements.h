// SPDX-License-Identifier: BSD-2-Clause
// Planes as the support points of the newest keyframe measure them (docs/math.md, section 9).
#pragma once

#include <vector>

#include "facet/map/plane_measurement.h"
#include "facet/mesh/search_mesh.h"
#include "facet/regularities/detect/surface_face.h"
#include "facet/regularities/regularity_options.h"
#include "facet/regularities/track/tracked_plane.h"

namespace facet {

/// One measurement for each plane of the estimator that is in view and that enough points
/// determine, in the order of `planes`. The points are support points that the keyframe itself has
/// matched, which the estimator does not have, inside the plane's extent and within three sigmas of
/// the plane: with a narrower gate the plane would confirm itself. Points all of whose faces are on
/// other planes (`plane_index_of_face`, -1: none) are left out. `mesh`, `faces` and `map` are of
/// one keyframe.
std::vector<PlaneMeasurement> MeasurePlanes(const SearchMesh& mesh,
                                            const SurfaceFaces& faces,
                                            const std::vector<int>& plane_index_of_face,
                                            const std::vector<TrackedPlane>& planes,
                                            const MapSnapshot& map,
                                            const PlaneMeasurementOptions& options);

}  // namespace facet
