// SPDX-License-Identifier: BSD-2-Clause
// JSON from and to text, in one place: the library's parser and writer take seconds to compile.
#pragma once

#include <filesystem>
#include <string>

#include <nlohmann/json_fwd.hpp>

namespace facet {

/// Null if the file is not there or does not hold JSON.
nlohmann::ordered_json ReadJsonFile(const std::filesystem::path& file);

/// On one line if `indent` is negative. Text from file names may be in any encoding; what is not
/// UTF-8 is replaced, not refused.
std::string JsonText(const nlohmann::ordered_json& json, int indent = -1);

}  // namespace facet
