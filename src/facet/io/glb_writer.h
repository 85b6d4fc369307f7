// SPDX-License-Identifier: BSD-2-Clause
// Binary glTF 2.0 (.glb), which Blender, browsers and phones open.
#pragma once

#include <filesystem>
#include <string>

#include "facet/mesh/triangle_mesh.h"

namespace facet {

/// One mesh with positions, normals and vertex colours, and a material that shows these colours
/// from both sides (without one glTF takes a surface for metal, which is black where it mirrors
/// nothing). A node turns z up into glTF's y up. Normals that the mesh does not have are made from
/// its faces, colours are grey; plane ids have no place in the format. A mesh without faces makes a
/// file with an empty scene.
std::string GlbBytes(const TriangleMesh& mesh);

/// Throws OutputError when the file cannot be written completely.
void WriteGlbMesh(const std::filesystem::path& file, const TriangleMesh& mesh);

}  // namespace facet
