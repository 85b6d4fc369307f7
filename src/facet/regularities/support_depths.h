// SPDX-License-Identifier: BSD-2-Clause
// Support points are matched once and never reach the estimator. Where their ray meets surface that
// is known to be a plane, the plane is a second measurement of their depth.
#pragma once

#include <vector>

#include "facet/regularities/known_plane.h"
#include "facet/regularities/regularity_options.h"
#include "facet/regularities/surface_face.h"

namespace facet {

/// For each vertex the factor by which its distance from the newest camera changes when that is
/// estimated from its own depth and from the plane behind it, weighted by their uncertainties; 1
/// for landmarks, for points out of view, and for points that contradict every plane. The planes
/// never see the result: whether surface is known is said by faces with their depths as matched.
std::vector<double> SupportDepthScales(const SearchMesh& mesh,
                                       const SurfaceFaces& faces,
                                       const std::vector<KnownPlane>& planes,
                                       const SE3& T_WB,
                                       const SupportDepthOptions& options);

}  // namespace facet
