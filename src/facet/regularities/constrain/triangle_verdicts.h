// SPDX-License-Identifier: BSD-2-Clause
// What tracked planes say about the triangles of the mesh: a triangle that lies on a plane is
// surface even where its size or its angle speak against it, and one that leads from a plane to
// something else mostly crosses free space.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "facet/mesh/mesh_regularities.h"
#include "facet/regularities/detect/surface_face.h"
#include "facet/regularities/regularity_options.h"
#include "facet/regularities/track/tracked_plane.h"

namespace facet {

/// One verdict per triangle, whose corners are indices into `points`.
std::vector<TriangleVerdict> JudgeTriangles(std::span<const FacePoint> points,
                                            std::span<const std::array<int, 3>> triangles,
                                            const std::vector<TrackedPlane>& planes,
                                            const SE3& T_WB,
                                            const RegularityOptions& options);

}  // namespace facet
