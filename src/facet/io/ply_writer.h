// SPDX-License-Identifier: BSD-2-Clause
// PLY files that MeshLab, CloudCompare and Open3D read: binary little endian.
#pragma once

#include <filesystem>
#include <span>

#include "facet/base/types.h"

namespace facet {

/// Points as float x y z. Throws OutputError when the file cannot be written completely.
void WritePlyPoints(const std::filesystem::path& file, std::span<const Vector3d> points);

}  // namespace facet
