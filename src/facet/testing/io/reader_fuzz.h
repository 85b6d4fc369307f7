// SPDX-License-Identifier: BSD-2-Clause
// For fuzzing: every reader of files, each with files that it takes. A reader may take a file or
// complain about it (errors.h); it may not crash, hang or fail in any other way.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace facet {

struct FuzzedReader {
  std::string name;
  std::string file_name;           ///< under which the reader expects its file
  std::vector<std::string> seeds;  ///< contents of good files
  std::function<void(const std::filesystem::path&)> read;
};

/// All readers that the program opens a user's files with.
std::vector<FuzzedReader> FuzzedReaders();

/// Writes the content to a file in `folder` and lets the reader read it. Returns whether it was
/// taken; what is neither InputError nor ConfigError is let through.
bool ReadsOrComplains(const FuzzedReader& reader,
                      const std::filesystem::path& folder,
                      const std::string& content);

}  // namespace facet
