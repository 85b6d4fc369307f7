// SPDX-License-Identifier: BSD-2-Clause
// Parameters from YAML and from `--set key.path=value`, strictly: a key that no options struct
// lists, a value of the wrong type or out of range is an error with file, line and the allowed
// range.
//
// Any options struct with a `Visit` member (base/options.h) becomes a list of fields; everything
// else works on that list.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "facet/base/options.h"

namespace facet {

/// An enumerator; its number is its place in ConfigField::choices.
struct EnumValue {
  void* value;
  int (*get)(const void* value);
  void (*set)(void* value, int number);
};

/// One parameter of an options struct. Points into the struct it was listed from.
struct ConfigField {
  std::string key;  ///< full path, for example "frontend.klt.num_levels"
  std::variant<bool*, int*, double*, std::string*, EnumValue> value;
  Range range;
  std::vector<std::string> choices;  ///< allowed texts; empty: any
  std::string doc;
  Audience audience = Audience::kExperts;
};

/// The visitor that lists an options struct. Use ListFields.
class FieldCollector {
 public:
  template <class T>
  void Field(const std::string& key,
             T& value,
             Range range,
             const std::string& doc,
             Audience audience = Audience::kExperts) {
    fields_.push_back({prefix_ + key, &value, range, {}, doc, audience});
  }
  template <class T>
  void Field(const std::string& key, T& value, const std::string& doc) {
    Field(key, value, {}, doc);
  }
  /// A text out of a list.
  void Choice(const std::string& key,
              std::string& value,
              const std::vector<std::string>& choices,
              const std::string& doc,
              Audience audience = Audience::kExperts) {
    fields_.push_back({prefix_ + key, &value, {}, choices, doc, audience});
  }
  /// An enumerator; `names` are those of the enumerators 0, 1, ...
  template <class Enum>
  requires std::is_enum_v<Enum>
  void Choice(const std::string& key,
              Enum& value,
              const std::vector<std::string>& names,
              const std::string& doc,
              Audience audience = Audience::kExperts) {
    const EnumValue reference = {
        &value,
        [](const void* v) { return static_cast<int>(*static_cast<const Enum*>(v)); },
        [](void* v, int number) { *static_cast<Enum*>(v) = static_cast<Enum>(number); }};
    fields_.push_back({prefix_ + key, reference, {}, names, doc, audience});
  }
  template <class Options>
  void Group(const std::string& key, Options& options) {
    const std::string outer = prefix_;
    prefix_ += key + ".";
    options.Visit(*this);
    prefix_ = outer;
  }

  std::vector<ConfigField> TakeFields() { return std::move(fields_); }

 private:
  std::string prefix_;
  std::vector<ConfigField> fields_;
};

/// All parameters of `options`, in the order of its Visit.
template <class Options>
std::vector<ConfigField> ListFields(Options& options) {
  FieldCollector collector;
  options.Visit(collector);
  return collector.TakeFields();
}

/// A value that somebody asked for.
struct ConfigEntry {
  std::string key;
  std::string text;
  std::string origin;  ///< "file:line" or "--set"
};

/// Flattens a YAML file. Throws ConfigError with file and line for bad syntax, lists and keys that
/// appear twice. A file without any key is fine.
std::vector<ConfigEntry> ReadConfigFile(const std::filesystem::path& file);

/// "key.path=value". Throws ConfigError.
ConfigEntry ParseOverride(const std::string& text);

/// Writes the entries, in order, into the fields. Throws ConfigError that names the origin, the key
/// and what is allowed: unknown key (with the nearest known or retired one), wrong type, out of
/// range. Either all entries up to the bad one were applied, or all.
///
/// `retired` options are no error where they have the value that they had by default, or where
/// another option replaced them, which then gets the value. Returns one line for each of them.
std::vector<std::string> ApplyConfig(std::span<const ConfigEntry> entries,
                                     std::span<const ConfigField> fields,
                                     std::span<const RetiredOption> retired = {});

/// Each "key.path=value" in order, so that the last one wins. Throws ConfigError.
std::vector<std::string> ApplyOverrides(std::span<const std::string> overrides,
                                        std::span<const ConfigField> fields,
                                        std::span<const RetiredOption> retired = {});

/// The value as it stands in YAML; reading it back gives the identical one.
std::string FormatValue(const ConfigField& field);

/// YAML with the value, meaning and range of every parameter, or of those for users. Reading it
/// back gives identical values.
std::string FormatConfig(std::span<const ConfigField> fields,
                         Audience audience = Audience::kExperts);

}  // namespace facet
