// SPDX-License-Identifier: BSD-2-Clause
// Normals of the vertices of a triangle mesh.
#pragma once

#include "facet/mesh/triangle_mesh.h"

namespace facet {

/// Fills mesh.normals: the mean of the adjacent faces' normals weighted by their area, unit length;
/// up where a vertex has no face with an area.
void SetVertexNormals(TriangleMesh& mesh);

}  // namespace facet
