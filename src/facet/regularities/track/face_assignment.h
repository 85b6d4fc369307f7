// SPDX-License-Identifier: BSD-2-Clause
// Which faces of the mesh lie on tracked planes that are in view, and which plane each piece of
// surface belongs to.
#pragma once

#include <vector>

#include "facet/map/plane_assignments.h"
#include "facet/regularities/detect/surface_face.h"
#include "facet/regularities/regularity_options.h"
#include "facet/regularities/track/tracked_plane.h"

namespace facet {

/// For each face its plane, an index into `planes`, or -1. A face is on a plane when all its
/// corners are within the gate and it is near the plane's extent; of several planes the nearest one
/// gets it. Where a board leans on a wall, each of the two is within the gate of the other along
/// the line where they meet: a plane therefore does not grow onto the extent of a plane that
/// crosses it there. Tentative and dormant planes get no faces.
std::vector<int> AssignFaces(const SurfaceFaces& faces,
                             const std::vector<TrackedPlane>& planes,
                             const MapSnapshot& map,
                             const RegularityOptions& options);

/// Adds the faces that the newest keyframe shows to the extents of their planes, and takes them
/// from the extents of planes that cross there and are farther off. `plane_index_of_face` as from
/// AssignFaces.
void ExtendPlanes(const SurfaceFaces& faces,
                  const std::vector<int>& plane_index_of_face,
                  Timestamp now,
                  std::vector<TrackedPlane>& planes);

/// Detaches the landmarks that are outside the extent of their plane and inside that of a plane
/// that crosses it.
void DetachFromForeignSurface(const MapSnapshot& map,
                              const std::vector<TrackedPlane>& planes,
                              PlaneAssignments& out);

}  // namespace facet
