// SPDX-License-Identifier: BSD-2-Clause
// Support points are matched once and never reach the estimator. Where their ray meets the extent
// of a plane, the plane is a second measurement of their depth.
#pragma once

#include <vector>

#include "facet/regularities/detect/surface_face.h"
#include "facet/regularities/track/tracked_plane.h"

namespace facet {

/// For each vertex the factor by which its distance from the newest camera changes when its matched
/// depth is fused with the plane behind it, by inverse variances; 1 for landmarks, for points out
/// of view, and for points that no plane explains. The search for planes never sees the result: it
/// works on depths as matched.
std::vector<double> SupportDepthScales(const SearchMesh& mesh,
                                       const SurfaceFaces& faces,
                                       const std::vector<TrackedPlane>& planes,
                                       const SE3& T_WB);

}  // namespace facet
