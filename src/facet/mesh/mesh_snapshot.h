// SPDX-License-Identifier: BSD-2-Clause
// Immutable copy of the horizon mesh after a keyframe: for planners, plane detection, viewers,
// files.
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
  double focal_px = 0;                 ///< of that camera
  std::vector<LandmarkId> vertex_ids;  ///< one per vertex, ascending; see IsSupport
  /// Ids of the support points that this keyframe has matched: from the first to before the end.
  /// The other support ids are of corners that the estimator has, too, and of guesses.
  LandmarkId first_match, end_match;
  std::vector<double> sigma_depth_m;  ///< one per vertex: 1-sigma of its distance from the camera
  std::vector<char> may_vote;         ///< one per face: passed the strict limits
  std::vector<char> in_view;          ///< one per face: triangulated in this keyframe
};

/// What the search for planes sees: faces that the mesh's own tests accepted, vertices as matched.
MeshSnapshot MakeMeshSnapshot(const MeshView& view, const HorizonMesh& horizon);

/// What is shown once planes had their say: with the faces that they add, without those that they
/// hide, and with the better depths of support points.
MeshSnapshot MakeShownSnapshot(const MeshView& view, const HorizonMesh& horizon);

}  // namespace facet
