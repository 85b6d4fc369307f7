// SPDX-License-Identifier: BSD-2-Clause
// A YAML file whose every complaint names file and line. Underneath the calibration and
// configuration readers; the only header that shows yaml-cpp.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <yaml-cpp/yaml.h>

namespace facet {

/// Accepts OpenCV's `%YAML:1.0` line, which is not YAML. All functions throw InputError.
class YamlFile {
 public:
  /// The root must be a map; a file without content has none and counts as an empty map. Refuses
  /// what is no regular file or larger than 16 MB, keys that stand twice, and aliases that lead
  /// back to themselves.
  explicit YamlFile(std::filesystem::path file);

  const std::filesystem::path& file() const { return file_; }
  const YAML::Node& root() const { return root_; }

  std::string Where(const YAML::Node& node) const;  ///< "file:line"

  /// Whether `parent` is a map that has the key.
  static bool Has(const YAML::Node& parent, const std::string& key);

  YAML::Node Require(const YAML::Node& parent, const std::string& key) const;
  std::string RequireText(const YAML::Node& parent, const std::string& key) const;
  double RequireNumber(const YAML::Node& parent, const std::string& key) const;  ///< finite

  /// All numbers of a scalar or of a (nested) sequence, row by row; each must be finite.
  std::vector<double> Numbers(const YAML::Node& node) const;

  /// Throws InputError "file:line: message".
  [[noreturn]] void Fail(const YAML::Node& node, const std::string& message) const;

 private:
  void CheckShape(const YAML::Node& node, int depth, int& num_nodes) const;

  std::filesystem::path file_;
  YAML::Node root_;
};

}  // namespace facet
