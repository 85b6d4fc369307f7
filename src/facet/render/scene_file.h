// SPDX-License-Identifier: BSD-2-Clause
// Scenes that a user describes in YAML (docs/simulator.md).
#pragma once

#include <filesystem>
#include <vector>

#include "facet/render/scene_builder.h"

namespace facet {

/// Builds the objects of the file. Throws InputError with file and line for unknown keys, types and
/// materials (the message lists the known ones), sizes that are not positive, unreadable images and
/// meshes without usable triangles.
SceneModel ReadSceneFile(const std::filesystem::path& file,
                         std::uint64_t seed,
                         MaterialLibrary& materials);

/// The `route` of the file, along which made-up flights go. Throws InputError.
std::vector<Vector3d> ReadSceneRoute(const std::filesystem::path& file);

}  // namespace facet
