// SPDX-License-Identifier: BSD-2-Clause
// How well the vertices of a mesh are known, beside its file: mesh.sigma beside mesh.ply, and
// mesh_sigmas/T.sigma for meshes/T.ply. A line "sigma_m", then the 1-sigma of each vertex's
// distance from the camera [m], a line each.
#pragma once

#include <filesystem>
#include <span>

#include "facet/mesh/triangle_mesh.h"

namespace facet {

inline constexpr const char* kSigmaFolder = "mesh_sigmas";

/// Nothing is written where there are none. Throws OutputError.
void WriteVertexSigmas(const std::filesystem::path& mesh_file, std::span<const float> sigma_m);

/// Sets those of a mesh that was read from the file, or none where they are not there. Throws
/// InputError where the file beside it is not of this mesh, or damaged.
void ReadVertexSigmas(const std::filesystem::path& mesh_file, TriangleMesh& mesh);

}  // namespace facet
