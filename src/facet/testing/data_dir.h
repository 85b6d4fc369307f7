// SPDX-License-Identifier: BSD-2-Clause
// Where tests and benchmarks find recorded data, which is not part of the repository.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

#include "facet/testing/folders.h"

namespace facet::testing {

/// Folder or file `name` of the recorded data: under $FACET_DATA_DIR, or if that is not set under
/// ../shared/data beside the source tree. Empty if it is not there; a test then says so and skips:
///   if (!DataDir("euroc_april_corners")) GTEST_SKIP() << MissingData("euroc_april_corners");
inline std::optional<std::filesystem::path> DataDir(const std::string& name) {
  const char* root = std::getenv("FACET_DATA_DIR");
  std::filesystem::path path = root && *root ? std::filesystem::path(root)
                                             : SourceFolder().parent_path() / "shared" / "data";
  path /= name;
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return std::nullopt;
  return path;
}

inline std::string MissingData(const std::string& name) {
  return "no recorded data \"" + name + "\": set FACET_DATA_DIR to the folder that holds it";
}

}  // namespace facet::testing
