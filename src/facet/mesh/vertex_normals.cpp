// SPDX-License-Identifier: BSD-2-Clause
#include "facet/mesh/vertex_normals.h"

namespace facet {

void SetVertexNormals(TriangleMesh& mesh) {
  mesh.normals.assign(mesh.vertices.size(), Vector3d::Zero());
  for (const auto& [i, j, k] : mesh.faces) {
    const Vector3d& a = mesh.vertices[i];
    const Vector3d twice_area = (mesh.vertices[j] - a).cross(mesh.vertices[k] - a);
    for (int corner : {i, j, k})
      mesh.normals[corner] += twice_area;
  }
  for (Vector3d& n : mesh.normals) {
    const double length = n.norm();
    n = length > 0 ? Vector3d(n / length) : Vector3d(0, 0, 1);
  }
}

}  // namespace facet
