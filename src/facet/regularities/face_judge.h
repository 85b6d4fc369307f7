// SPDX-License-Identifier: BSD-2-Clause
// Known planes judge the triangles of the mesh: a triangle that lies on a plane is surface even
// where its size or its angle speak against it, and one that leads from a plane to something else
// mostly crosses free space.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "facet/mesh/mesh_regularities.h"
#include "facet/regularities/known_plane.h"
#include "facet/regularities/regularity_options.h"
#include "facet/regularities/surface_face.h"

namespace facet {

/// One standing per triangle, whose corners are places in `points`. Deterministic; the planes do
/// not change.
std::vector<TriangleVerdict> JudgeFaces(std::span<const FacePoint> points,
                                        std::span<const std::array<int, 3>> triangles,
                                        const std::vector<KnownPlane>& planes,
                                        const SE3& T_WB,
                                        const RegularityOptions& options);

}  // namespace facet
