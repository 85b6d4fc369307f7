// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/json_file.h"

#include <fstream>

#include <nlohmann/json.hpp>

namespace facet {

using nlohmann::ordered_json;

ordered_json ReadJsonFile(const std::filesystem::path& file) {
  std::ifstream stream(file);
  ordered_json json = ordered_json::parse(stream, nullptr, false);
  return json.is_discarded() ? ordered_json() : json;
}

std::string JsonText(const ordered_json& json, int indent) {
  return json.dump(indent, ' ', false, ordered_json::error_handler_t::replace);
}

}  // namespace facet
