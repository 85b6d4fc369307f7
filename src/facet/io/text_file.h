// SPDX-License-Identifier: BSD-2-Clause
// Writing text files completely or not at all.
#pragma once

#include <filesystem>
#include <string>

namespace facet {

/// For files inside a folder that is itself put in place as a whole. Throws OutputError when the
/// file cannot be written completely; what was written of it then stays.
void WriteTextFile(const std::filesystem::path& file, const std::string& text);

/// Writes beside `file` and renames: the file is the old or the new one, never half of it. Throws
/// OutputError; nothing is left behind then.
void ReplaceTextFile(const std::filesystem::path& file, const std::string& text);

}  // namespace facet
