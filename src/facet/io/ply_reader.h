// SPDX-License-Identifier: BSD-2-Clause
// PLY files of other programs and of our own: ASCII and binary little endian, points or meshes.
#pragma once

#include <filesystem>

#include "facet/mesh/triangle_mesh.h"

namespace facet {

/// Reads vertices (x y z, and nx ny nz, red green blue, sigma_m where they are there) and
/// faces (vertex_indices or vertex_index, and plane_id); other elements and properties are skipped.
/// Polygons become fans of triangles that share their polygon's plane_id.
///
/// Throws InputError with the file, and the line or the number of the vertex or face, for anything
/// else than PLY, unknown formats and types, a file that ends early, coordinates that are not
/// finite, and faces with vertices that do not exist. A file without vertices is refused; whether
/// faces are needed is for the caller to say.
TriangleMesh ReadPly(const std::filesystem::path& file);

}  // namespace facet
