// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/config_file.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <system_error>

#include "facet/io/csv_reader.h"
#include "facet/io/errors.h"
#include "facet/io/yaml_file.h"

namespace facet {
namespace {

// ------------------------------------------------------------------------------- text and numbers

/// Shortest text that reads back as the same double.
std::string FormatDouble(double value) {
  if (std::isinf(value)) return value > 0 ? ".inf" : "-.inf";
  if (std::isnan(value)) return ".nan";
  char text[40];
  const auto [end, error] = std::to_chars(text, text + sizeof(text), value);
  return error == std::errc() ? std::string(text, end) : std::string();
}

std::string FormatText(const std::string& value) {
  std::string quoted = "\"";
  for (char c : value) {
    if (c == '"' || c == '\\') quoted.push_back('\\');
    quoted += c == '\n' ? "\\n" : c == '\t' ? "\\t" : std::string(1, c);
  }
  return quoted + "\"";
}

struct Formatter {
  const ConfigField& field;

  std::string operator()(const EnumValue& v) const {
    return FormatText(field.choices[static_cast<std::size_t>(v.get(v.value))]);
  }
  std::string operator()(const bool* v) const { return *v ? "true" : "false"; }
  std::string operator()(const int* v) const { return std::to_string(*v); }
  std::string operator()(const double* v) const { return FormatDouble(*v); }
  std::string operator()(const std::string* v) const { return FormatText(*v); }
};

std::optional<double> ParseYamlDouble(const std::string& text) {
  if (text == ".inf" || text == "+.inf") return std::numeric_limits<double>::infinity();
  if (text == "-.inf") return -std::numeric_limits<double>::infinity();
  const auto value = ParseDouble(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

/// "0 .. 5", ">= 0", "<= 5", "a | b", or empty where everything is allowed.
std::string DescribeAllowed(const ConfigField& field) {
  if (!field.choices.empty()) {
    std::string text;
    for (const std::string& choice : field.choices)
      text += (text.empty() ? "" : " | ") + choice;
    return text;
  }
  const bool is_number =
      std::holds_alternative<int*>(field.value) || std::holds_alternative<double*>(field.value);
  if (!is_number) return "";
  const Range& range = field.range;
  const bool has_min = std::isfinite(range.min), has_max = std::isfinite(range.max);
  if (has_min && has_max) return FormatDouble(range.min) + " .. " + FormatDouble(range.max);
  if (has_min) return ">= " + FormatDouble(range.min);
  if (has_max) return "<= " + FormatDouble(range.max);
  return "";
}

// ------------------------------------------------------------------------------------ applying

/// Parses a text into the field it points to; returns what is wrong, or an empty text.
struct Setter {
  const std::string& text;
  const ConfigField& field;

  std::string operator()(bool* v) const {
    if (text != "true" && text != "false") return "must be true or false";
    *v = text == "true";
    return "";
  }
  std::string operator()(int* v) const {
    constexpr auto kMin = std::numeric_limits<int>::min(), kMax = std::numeric_limits<int>::max();
    const auto value = ParseInteger(text);
    if (!value) return "must be an integer" + Allowed();
    const bool fits = *value >= kMin && *value <= kMax;
    if (!fits || !IsInside(static_cast<double>(*value))) return "is out of range" + Allowed();
    *v = static_cast<int>(*value);
    return "";
  }
  std::string operator()(double* v) const {
    const auto value = ParseYamlDouble(text);
    if (!value) return "must be a number" + Allowed();
    if (!IsInside(*value)) return "is out of range" + Allowed();
    *v = *value;
    return "";
  }
  std::string operator()(std::string* v) const {
    if (!field.choices.empty() && PlaceOfChoice() < 0) return "is not one of these" + Allowed();
    *v = text;
    return "";
  }
  std::string operator()(const EnumValue& v) const {
    const int place = PlaceOfChoice();
    if (place < 0) return "is not one of these" + Allowed();
    v.set(v.value, place);
    return "";
  }

  int PlaceOfChoice() const {
    const auto& choices = field.choices;
    const auto found = std::find(choices.begin(), choices.end(), text);
    return found == choices.end() ? -1 : static_cast<int>(found - choices.begin());
  }

  bool IsInside(double value) const { return value >= field.range.min && value <= field.range.max; }
  std::string Allowed() const {
    const std::string allowed = DescribeAllowed(field);
    return allowed.empty() ? "" : ", allowed: " + allowed;
  }
};

std::size_t EditDistance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j)
    row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row[b.size()];
}

std::string LastPart(const std::string& key) {
  return key.substr(key.rfind('.') + 1);
}

/// How far a key is from the one that somebody wrote; the same name in another group is near.
std::size_t Distance(const std::string& key, const std::string& written) {
  return LastPart(key) == LastPart(written) ? 0 : EditDistance(key, written);
}

std::string InWords(const RetiredOption& option) {
  const std::string new_key = option.new_key;
  return "did you mean '" + std::string(option.key) + "', which is " +
         (new_key.empty() ? "no option any more?" : "now called '" + new_key + "'?");
}

/// A hint in words for an unknown key.
std::string Suggest(const std::string& key,
                    std::span<const ConfigField> fields,
                    std::span<const RetiredOption> retired) {
  const std::string group = key + ".";
  std::string best = "`facet config --all` prints all keys";
  std::size_t best_distance = std::max<std::size_t>(3, key.size() / 3) + 1;
  for (const ConfigField& field : fields) {
    if (field.key.starts_with(group)) return "it is a group; its keys begin with '" + group + "'";
    const std::size_t distance = Distance(field.key, key);
    if (distance >= best_distance) continue;
    best = "did you mean '" + field.key + "'?";
    best_distance = distance;
  }
  for (const RetiredOption& option : retired) {
    const std::size_t distance = Distance(option.key, key);
    if (distance >= best_distance) continue;
    best = InWords(option);
    best_distance = distance;
  }
  return best;
}

// ------------------------------------------------------------------------------------- reading

class Flattener {
 public:
  explicit Flattener(const YamlFile& yaml) : yaml_(yaml) {}

  void Add(const YAML::Node& map, const std::string& prefix) {
    for (const auto& item : map) {
      if (!item.first.IsScalar()) Fail(item.first, "a key must be a word");
      const std::string key = prefix + item.first.Scalar();
      const YAML::Node& value = item.second;
      if (value.IsSequence())
        Fail(item.first, "'" + key + "' is a list; parameters are single values");
      if (value.IsNull()) Fail(item.first, "'" + key + "' has no value");
      const std::string where = yaml_.Where(item.first);
      const auto [first, is_new] = seen_.emplace(key, where);
      if (!is_new) Fail(item.first, "'" + key + "' appears twice, first in " + first->second);
      if (value.IsMap()) {
        Add(value, key + ".");
      } else {
        entries_.push_back({key, value.Scalar(), where});
      }
    }
  }
  std::vector<ConfigEntry> TakeEntries() { return std::move(entries_); }

 private:
  [[noreturn]] void Fail(const YAML::Node& node, const std::string& message) const {
    throw ConfigError(yaml_.Where(node) + ": " + message);
  }
  const YamlFile& yaml_;
  std::map<std::string, std::string> seen_;  // key and where it is
  std::vector<ConfigEntry> entries_;
};

}  // namespace

std::vector<ConfigEntry> ReadConfigFile(const std::filesystem::path& file) {
  try {
    const YamlFile yaml(file);
    Flattener flattener(yaml);
    flattener.Add(yaml.root(), "");
    return flattener.TakeEntries();
  } catch (const InputError& error) {
    throw ConfigError(error.what());
  }
}

ConfigEntry ParseOverride(const std::string& text) {
  const std::size_t equals = text.find('=');
  const std::string_view all = text;
  if (equals == std::string::npos || Trim(all.substr(0, equals)).empty()) {
    throw ConfigError("--set " + text + ": key.path=value is expected");
  }
  return {
      std::string(Trim(all.substr(0, equals))), std::string(Trim(all.substr(equals + 1))), "--set"};
}

namespace {

/// Sets the field with this key; false if there is none.
bool Set(const std::string& key, const ConfigEntry& entry, std::span<const ConfigField> fields) {
  const auto field = std::find_if(
      fields.begin(), fields.end(), [&](const ConfigField& f) { return f.key == key; });
  if (field == fields.end()) return false;
  const std::string problem = std::visit(Setter{entry.text, *field}, field->value);
  if (!problem.empty())
    throw ConfigError(entry.origin + ": " + entry.key + " = '" + entry.text + "' " + problem);
  return true;
}

bool SameValue(const std::string& a, const std::string& b) {
  const auto x = ParseYamlDouble(a), y = ParseYamlDouble(b);
  return x && y ? *x == *y : a == b;
}

/// What to tell the user about an option of earlier versions.
std::string ApplyRetired(const ConfigEntry& entry,
                         const RetiredOption& option,
                         std::span<const ConfigField> fields) {
  const std::string new_key = option.new_key;
  if (!new_key.empty() && Set(new_key, entry, fields))
    return entry.origin + ": " + entry.key + " is now called " + new_key;
  const std::string now = option.now;
  const std::string fixed =
      "is now " + (now.empty() ? "fixed at " + std::string(option.default_text) : now);
  if (!SameValue(entry.text, option.default_text)) {
    throw ConfigError(entry.origin + ": " + entry.key + " = '" + entry.text + "': " + entry.key +
                      " is no option any more, it " + fixed + "; remove it");
  }
  return entry.origin + ": " + entry.key + " " + fixed + " and can be removed";
}

}  // namespace

std::vector<std::string> ApplyConfig(std::span<const ConfigEntry> entries,
                                     std::span<const ConfigField> fields,
                                     std::span<const RetiredOption> retired) {
  std::vector<std::string> notices;
  for (const ConfigEntry& entry : entries) {
    if (Set(entry.key, entry, fields)) continue;
    const auto option = std::find_if(
        retired.begin(), retired.end(), [&](const RetiredOption& r) { return r.key == entry.key; });
    if (option == retired.end()) {
      throw ConfigError(entry.origin + ": unknown key '" + entry.key + "'; " +
                        Suggest(entry.key, fields, retired));
    }
    notices.push_back(ApplyRetired(entry, *option, fields));
  }
  return notices;
}

std::string FormatValue(const ConfigField& field) {
  return std::visit(Formatter{field}, field.value);
}

std::string FormatConfig(std::span<const ConfigField> fields, Audience audience) {
  std::string text;
  std::vector<std::string> open;  // groups that the last line was in
  for (const ConfigField& field : fields) {
    if (audience == Audience::kUsers && field.audience != Audience::kUsers) continue;
    std::vector<std::string> groups;
    std::size_t begin = 0;
    for (std::size_t dot; (dot = field.key.find('.', begin)) != std::string::npos;
         begin = dot + 1) {
      groups.push_back(field.key.substr(begin, dot - begin));
    }
    std::size_t common = 0;
    while (common < std::min(open.size(), groups.size()) && open[common] == groups[common])
      ++common;
    for (std::size_t i = common; i < groups.size(); ++i) {
      text += std::string(2 * i, ' ') + groups[i] + ":\n";
    }
    open = groups;
    const std::string allowed = DescribeAllowed(field);
    text += std::string(2 * groups.size(), ' ') + LastPart(field.key) + ": " + FormatValue(field) +
            "  # " + field.doc + (allowed.empty() ? "" : " [" + allowed + "]") + "\n";
  }
  return text;
}

std::vector<std::string> ApplyOverrides(std::span<const std::string> overrides,
                                        std::span<const ConfigField> fields,
                                        std::span<const RetiredOption> retired) {
  std::vector<ConfigEntry> entries;
  for (const std::string& text : overrides)
    entries.push_back(ParseOverride(text));
  return ApplyConfig(entries, fields, retired);
}

}  // namespace facet
