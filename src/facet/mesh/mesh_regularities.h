// SPDX-License-Identifier: BSD-2-Clause
// What the planes of the estimator say about the horizon mesh, as plain data: who finds planes
// knows the mesh, the mesh does not know planes.
#pragma once

#include <vector>

namespace facet {

/// How the known planes judge one triangle.
struct TriangleVerdict {
  int plane_id = -1;       ///< all corners lie on this plane, over or beside its known surface
  bool is_bridge = false;  ///< leads from a plane to something else, through free space
};

/// Belongs to one SearchMesh.
struct MeshRegularities {
  std::vector<int> face_plane_ids;        ///< the plane of each of its faces, -1: none
  std::vector<double> depth_scales;       ///< one per vertex, or empty: see SearchMesh::ShownWith
  std::vector<TriangleVerdict> verdicts;  ///< one for each of its triangles
};

}  // namespace facet
