// SPDX-License-Identifier: BSD-2-Clause
// PLY files that MeshLab, CloudCompare and Open3D read: binary little endian.
#pragma once

#include <filesystem>
#include <span>

#include "facet/mesh/triangle_mesh.h"

namespace facet {

/// Points as float x y z. Throws OutputError when the file cannot be written completely.
void WritePlyPoints(const std::filesystem::path& file, std::span<const Vector3d> points);

/// A mesh as in mesh.ply and map.ply: float x y z nx ny nz, uchar red green blue, and float sigma_m
/// where the mesh has it; faces with int plane_id. Other parts that the mesh does not have are
/// written as up, grey and -1. CHECKs that the
/// optional parts are empty or complete; throws OutputError like WritePlyPoints.
void WritePlyMesh(const std::filesystem::path& file, const TriangleMesh& mesh);

}  // namespace facet
