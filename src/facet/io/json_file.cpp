// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/json_file.h"

#include <fstream>
#include <iterator>

#include <nlohmann/json.hpp>

#include "facet/io/errors.h"

namespace facet {

using nlohmann::ordered_json;

namespace {

bool IsTooDeep(std::string_view text) {
  constexpr int kDeepest = 100;
  int depth = 0;
  bool is_in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (is_in_string && c == '\\') {
      ++i;  // what follows is a character, whatever it is
    } else if (c == '"') {
      is_in_string = !is_in_string;
    } else if (!is_in_string && (c == '[' || c == '{')) {
      if (++depth > kDeepest) return true;
    } else if (!is_in_string && (c == ']' || c == '}')) {
      --depth;
    }
  }
  return false;
}

// Empty for what is no file: a pipe would be waited for, a device read for ever.
std::string ReadText(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) return {};
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

}  // namespace

ordered_json ParseJson(std::string_view text) {
  if (IsTooDeep(text)) return {};
  ordered_json json = ordered_json::parse(text, nullptr, false);
  return json.is_discarded() ? ordered_json() : json;
}

ordered_json ReadJsonFile(const std::filesystem::path& file) {
  return ParseJson(ReadText(file));
}

ordered_json ReadJsonObject(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error))
    throw InputError(file.string() + ": no such file, or none that can be read");
  const std::string text = ReadText(file);
  if (IsTooDeep(text))
    throw InputError(file.string() + ": is damaged: lists or objects lie in each other too deep");
  try {
    ordered_json json = ordered_json::parse(text);
    if (json.is_object()) return json;
  } catch (const ordered_json::parse_error& wrong) {
    throw InputError(file.string() + ": is damaged: not JSON from byte " +
                     std::to_string(wrong.byte) + " of " + std::to_string(text.size()) + " on");
  }
  throw InputError(file.string() + ": is damaged: a JSON object is expected");
}

std::string JsonText(const ordered_json& json, int indent) {
  return json.dump(indent, ' ', false, ordered_json::error_handler_t::replace);
}

}  // namespace facet
