// SPDX-License-Identifier: BSD-2-Clause
// Immutable copy of the horizon mesh after a keyframe: for planners, viewers, files.
#pragma once

#include <vector>

#include "facet/mesh/horizon_mesh.h"
#include "facet/mesh/triangle_mesh.h"

namespace facet {

struct MeshSnapshot {
  FrameId frame;
  Timestamp t;
  TriangleMesh mesh;                   ///< in W, with normals, colours and plane ids
  SE3 T_WC;                            ///< left camera of the keyframe
  std::vector<LandmarkId> vertex_ids;  ///< one per vertex, ascending; see IsSupport
  std::vector<double> sigma_depth_m;   ///< one per vertex: 1-sigma of its distance from the camera
  std::vector<char> may_vote;          ///< one per face: passed the strict limits
  std::vector<char> in_view;           ///< one per face: triangulated in this keyframe
};

/// The mesh as it is shown: with the faces that planes add, without those that they hide, and with
/// the better depths of support points that lie on planes.
MeshSnapshot MakeMeshSnapshot(const MeshView& view, const HorizonMesh& horizon);

/// `sigma_depth_m` as files have it.
std::vector<float> VertexSigmas(const MeshSnapshot& snapshot);

/// The mesh with `sigma_depth_m` beside each vertex, where it is known.
TriangleMesh MeshWithSigmas(const MeshSnapshot& snapshot);

}  // namespace facet
