// SPDX-License-Identifier: BSD-2-Clause
// Removes planes of the estimator that turn out to be none, or not where the estimator has them.
#pragma once

#include <vector>

#include "facet/map/plane_assignments.h"
#include "facet/regularities/track/tracked_plane.h"

namespace facet {

/// Removes planes whose landmarks, as vision alone places them, do not fit: in three keyframes in a
/// row they lie on another plane or on none, or over many keyframes their mean square distance from
/// the plane that fits them best is too large. Their landmarks are detached;
/// the detector may find planes among them anew. Planes whose landmarks lie on a curved surface
/// stay, because seeing them again still helps the estimator, but it is recorded
/// (TrackedPlane::curvature). How uneven the surface of each plane is, is estimated and announced.
/// `camera`: of the newest view.
void RemoveMisfits(const MapSnapshot& map,
                   const FaceCamera& camera,
                   std::vector<TrackedPlane>& planes,
                   PlaneAssignments& out);

}  // namespace facet
