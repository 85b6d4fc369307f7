// SPDX-License-Identifier: BSD-2-Clause
// Second thoughts about planes that the estimator already has: one that is none, or not where the
// estimator believes it.
#pragma once

#include <vector>

#include "facet/map/plane_assignments.h"
#include "facet/regularities/known_plane.h"
#include "facet/regularities/regularity_options.h"

namespace facet {

/// Ends planes whose landmarks, where vision alone sees them, do not fit: in three keyframes in a
/// row they lie together on another plane or far from any, or over many keyframes their mean square
/// about the plane that fits them best is more than the options allow. The
/// landmarks leave, and what they were is for the detection to find anew.
/// Planes whose landmarks lie on a bend stay, because they are still of use to the estimator (they
/// are seen again), but it is counted (KnownPlane::bends). `sigma_direction` of a landmark [rad].
void EndMisfits(const MapSnapshot& map,
                double sigma_direction,
                const PlaneTrackingOptions& options,
                std::vector<KnownPlane>& planes,
                PlaneAssignments& out);

}  // namespace facet
