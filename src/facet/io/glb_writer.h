// SPDX-License-Identifier: BSD-2-Clause
// Binary glTF 2.0 (.glb), which Blender, browsers and phones open.
#pragma once

#include <filesystem>

#include "facet/mesh/triangle_mesh.h"

namespace facet {

/// One mesh with positions, normals and vertex colours; a node turns z up into glTF's y up. Normals
/// and colours that the mesh does not have are written as up and grey; plane ids have no place in
/// the format. A mesh without faces makes a file with an empty scene. Throws OutputError when the
/// file cannot be written completely.
void WriteGlbMesh(const std::filesystem::path& file, const TriangleMesh& mesh);

}  // namespace facet
