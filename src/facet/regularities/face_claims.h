// SPDX-License-Identifier: BSD-2-Clause
// Which faces of the mesh lie on planes that were seen a moment ago, and whose surface is where.
#pragma once

#include <vector>

#include "facet/map/plane_assignments.h"
#include "facet/regularities/known_plane.h"
#include "facet/regularities/regularity_options.h"
#include "facet/regularities/surface_face.h"

namespace facet {

/// For each face its plane, an index into `planes`, or -1. A face is on a plane when all its
/// corners are within the gate, near the known surface; of several the nearest one has it. Where a
/// board leans on a wall each is within the gate of the other along the line where both meet: a
/// plane therefore does not grow onto surface that is known to be that of one that crosses there.
std::vector<int> ClaimFaces(const SurfaceFaces& faces,
                            const std::vector<KnownPlane>& planes,
                            const MapSnapshot& map,
                            const PlaneTrackingOptions& options);

/// What the newest faces show becomes known surface of their planes, and is taken from planes that
/// cross there and are farther off. `plane_of_face` as from ClaimFaces.
void TakeSurface(const SurfaceFaces& faces,
                 const std::vector<int>& plane_of_face,
                 Timestamp now,
                 std::vector<KnownPlane>& planes);

/// Landmarks leave planes that have no surface where they are, if a plane that crosses there has.
void LeaveForeignSurface(const MapSnapshot& map,
                         const std::vector<KnownPlane>& planes,
                         PlaneAssignments& out);

}  // namespace facet
