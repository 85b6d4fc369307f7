// SPDX-License-Identifier: BSD-2-Clause
#include "facet/mesh/mesh_snapshot.h"

namespace facet {

MeshSnapshot MakeMeshSnapshot(const MeshView& view, const HorizonMesh& horizon) {
  MeshSnapshot snapshot;
  snapshot.frame = view.frame;
  snapshot.t = view.t;
  snapshot.T_WC = view.T_WC;
  snapshot.mesh = horizon.ToTriangleMesh();
  snapshot.vertex_ids.reserve(horizon.vertices().size());
  snapshot.sigma_depth_m.reserve(horizon.vertices().size());
  for (const MeshVertex& vertex : horizon.vertices()) {
    snapshot.vertex_ids.push_back(vertex.id);
    snapshot.sigma_depth_m.push_back(vertex.sigma_depth_m);
  }
  snapshot.may_vote.reserve(horizon.faces().size());
  snapshot.in_view.reserve(horizon.faces().size());
  for (const MeshFace& face : horizon.faces()) {
    snapshot.may_vote.push_back(face.may_vote ? 1 : 0);
    snapshot.in_view.push_back(face.in_view ? 1 : 0);
  }
  return snapshot;
}

}  // namespace facet
