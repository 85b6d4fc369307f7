// SPDX-License-Identifier: BSD-2-Clause
// A map of places as a file: "FACETMAP", the version, the size and the CRC-32 of what follows, then
// the map, little-endian.
#pragma once

#include <filesystem>

#include "facet/loop/saved_map.h"

namespace facet {

/// The file of a map's folder.
inline constexpr const char* kSavedMapName = "places.facetmap";

/// Replaces the folder's map as a whole, or leaves the old one; makes the folder if there is none.
/// Throws OutputError.
void WriteSavedMap(const std::filesystem::path& folder, const SavedMap& map);

/// Throws InputError, with the reason, where there is none, or where it is damaged, of another
/// version, or says what cannot be.
SavedMap ReadSavedMap(const std::filesystem::path& folder);

}  // namespace facet
