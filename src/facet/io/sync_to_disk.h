// SPDX-License-Identifier: BSD-2-Clause
// A rename is on the disk sooner than what was written before it, so that after a power cut a new
// file may be there and empty. What is synchronised first is there as a whole, or not at all.
#pragma once

#include <filesystem>

namespace facet {

/// Waits until a file, or a folder with everything in it, is on the disk. Throws OutputError if it
/// cannot be opened or the disk reports an error. File systems that cannot do it are left alone.
void SyncToDisk(const std::filesystem::path& file_or_folder);

}  // namespace facet
