// SPDX-License-Identifier: BSD-2-Clause
// JSON from and to text, in one place: the library's parser and writer take seconds to compile.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

namespace facet {

/// Null for a text that is not JSON, or whose lists and objects lie in each other more than 100
/// deep: the library follows them by recursion, and the stack would end before such a text.
nlohmann::ordered_json ParseJson(std::string_view text);

/// Null if the file is not there or does not hold JSON, as ParseJson takes it.
nlohmann::ordered_json ReadJsonFile(const std::filesystem::path& file);

/// Throws InputError, with the file and what is wrong with it, if it is not there, cannot be read,
/// or holds anything else than one JSON object.
nlohmann::ordered_json ReadJsonObject(const std::filesystem::path& file);

/// On one line if `indent` is negative. Text from file names may be in any encoding; what is not
/// UTF-8 is replaced, not refused.
std::string JsonText(const nlohmann::ordered_json& json, int indent = -1);

}  // namespace facet
