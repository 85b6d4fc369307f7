// SPDX-License-Identifier: BSD-2-Clause
// Where a test finds this project's files. The paths are in one source file, so that all others
// compile to the same bytes, and come out of a compiler cache, in every clone.
#pragma once

#include <filesystem>

namespace facet::testing {

std::filesystem::path SourceFolder();
std::filesystem::path BuildFolder();

}  // namespace facet::testing
