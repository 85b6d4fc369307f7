// SPDX-License-Identifier: BSD-2-Clause
#pragma once

#include "facet/mesh/triangle_mesh.h"

namespace facet {

/// Vertices in exactly one place become one (the first); faces that have no area or are there twice
/// go, and vertices of no face. The order of what stays is kept. Normals are not looked at.
void CleanUp(TriangleMesh& mesh);

}  // namespace facet
