// SPDX-License-Identifier: BSD-2-Clause
#include "facet/mesh/mesh_snapshot.h"

#include "facet/mesh/vertex_normals.h"

namespace facet {

// Vertices that no shown face needs are left out; the others keep their order.
MeshSnapshot MakeMeshSnapshot(const MeshView& view, const HorizonMesh& horizon) {
  MeshSnapshot snapshot;
  snapshot.frame = view.frame;
  snapshot.t = view.t;
  snapshot.T_WC = view.T_WC;
  TriangleMesh& mesh = snapshot.mesh;
  const std::size_t most_faces = horizon.faces().size(), most_vertices = horizon.vertices().size();
  mesh.faces.reserve(most_faces);
  mesh.plane_ids.reserve(most_faces);
  snapshot.may_vote.reserve(most_faces);
  snapshot.in_view.reserve(most_faces);
  mesh.vertices.reserve(most_vertices);
  mesh.colours.reserve(most_vertices);
  snapshot.vertex_ids.reserve(most_vertices);
  snapshot.sigma_depth_m.reserve(most_vertices);
  std::vector<int> index(most_vertices, -1);
  for (const MeshFace& face : horizon.faces()) {
    if (face.is_hidden) continue;
    mesh.faces.push_back(face.CounterClockwise());
    mesh.plane_ids.push_back(face.plane_id);
    snapshot.may_vote.push_back(face.may_vote ? 1 : 0);
    snapshot.in_view.push_back(face.in_view ? 1 : 0);
    for (const int corner : face.corners)
      index[corner] = 0;
  }
  for (std::size_t i = 0; i < index.size(); ++i) {
    if (index[i] < 0) continue;
    const MeshVertex& vertex = horizon.vertices()[i];
    index[i] = static_cast<int>(mesh.vertices.size());
    mesh.vertices.push_back(vertex.shown_W);
    mesh.colours.push_back({vertex.intensity, vertex.intensity, vertex.intensity});
    snapshot.vertex_ids.push_back(vertex.id);
    snapshot.sigma_depth_m.push_back(vertex.sigma_depth_m);
  }
  for (std::array<int, 3>& face : mesh.faces) {
    for (int& corner : face)
      corner = index[corner];
  }
  SetVertexNormals(mesh);
  return snapshot;
}

std::vector<float> VertexSigmas(const MeshSnapshot& snapshot) {
  return {snapshot.sigma_depth_m.begin(), snapshot.sigma_depth_m.end()};
}

TriangleMesh MeshWithSigmas(const MeshSnapshot& snapshot) {
  TriangleMesh mesh = snapshot.mesh;
  mesh.sigma_m = VertexSigmas(snapshot);
  return mesh;
}

}  // namespace facet
