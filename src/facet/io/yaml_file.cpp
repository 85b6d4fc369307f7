// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/yaml_file.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <map>
#include <sstream>
#include <system_error>
#include <utility>

#include "facet/io/csv_reader.h"
#include "facet/io/errors.h"

namespace facet {
namespace {

constexpr std::uintmax_t kMaxBytes = 16 << 20;
constexpr int kMaxDepth = 32;
constexpr int kMaxNodes = 200000;

/// Content of the file; directive lines become empty so that line numbers stay.
std::string ReadYamlText(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) throw InputError(file.string() + ": no such file");
  // A pipe would wait, a device never end.
  std::ifstream stream;
  if (std::filesystem::is_regular_file(file, error)) stream.open(file);
  if (!stream.is_open()) throw InputError(file.string() + ": cannot be read as a file");
  if (std::filesystem::file_size(file, error) > kMaxBytes)
    throw InputError(file.string() + ": larger than 16 MB; is it a configuration or calibration?");
  std::ostringstream text;
  std::string line;
  bool is_head = true;
  while (std::getline(stream, line)) {
    if (line.starts_with("\xEF\xBB\xBF")) line.erase(0, 3);
    const bool is_directive = is_head && line.starts_with('%');
    const bool is_content = !is_directive && !line.empty() && line.front() != '#';
    if (is_content) is_head = false;
    text << (is_directive ? "" : line) << '\n';
  }
  return text.str();
}

}  // namespace

YamlFile::YamlFile(std::filesystem::path file) : file_(std::move(file)) {
  try {
    root_ = YAML::Load(ReadYamlText(file_));
  } catch (const YAML::Exception& error) {
    throw InputError(file_.string() + ":" + std::to_string(error.mark.line + 1) +
                     ": not valid YAML: " + error.msg);
  }
  if (!root_.IsMap() && !root_.IsNull()) {
    throw InputError(file_.string() + ":1: must consist of 'key: value' pairs");
  }
  int num_nodes = 0;
  CheckShape(root_, 0, num_nodes);
}

// An alias may lead back to what holds it, or multiply; a key that stands twice has two values.
void YamlFile::CheckShape(const YAML::Node& node, int depth, int& num_nodes) const {
  if (depth > kMaxDepth || ++num_nodes > kMaxNodes)
    Fail(node, "nested too deeply or too large (an alias that leads back to itself?)");
  if (node.IsSequence()) {
    for (const YAML::Node& item : node)
      CheckShape(item, depth + 1, num_nodes);
  }
  if (!node.IsMap()) return;
  std::map<std::string, std::string> seen;  // key and where it is
  for (const auto& item : node) {
    if (item.first.IsScalar()) {
      const std::string& key = item.first.Scalar();
      const auto [first, is_new] = seen.emplace(key, Where(item.first));
      if (!is_new) Fail(item.first, "'" + key + "' appears twice, first in " + first->second);
    }
    CheckShape(item.second, depth + 1, num_nodes);
  }
}

std::string YamlFile::Where(const YAML::Node& node) const {
  return file_.string() + ":" + std::to_string(std::max(0, node.Mark().line) + 1);
}

bool YamlFile::Has(const YAML::Node& parent, const std::string& key) {
  return parent.IsMap() && parent[key].IsDefined();
}

YAML::Node YamlFile::Require(const YAML::Node& parent, const std::string& key) const {
  if (!Has(parent, key)) Fail(parent, "'" + key + "' is missing");
  return parent[key];
}

std::string YamlFile::RequireText(const YAML::Node& parent, const std::string& key) const {
  const YAML::Node node = Require(parent, key);
  if (!node.IsScalar()) Fail(node, "'" + key + "' must be a single word");
  return node.Scalar();
}

double YamlFile::RequireNumber(const YAML::Node& parent, const std::string& key) const {
  const YAML::Node node = Require(parent, key);
  const std::vector<double> numbers = Numbers(node);
  if (!node.IsScalar() || numbers.size() != 1) Fail(node, "'" + key + "' must be a single number");
  return numbers.front();
}

std::vector<double> YamlFile::Numbers(const YAML::Node& node) const {
  std::vector<double> numbers;
  if (node.IsScalar()) {
    const auto number = ParseDouble(Trim(node.Scalar()));
    if (!number || !std::isfinite(*number)) {
      Fail(node, "'" + node.Scalar() + "' where a finite number is expected");
    }
    numbers.push_back(*number);
  } else if (node.IsSequence()) {
    for (const YAML::Node& element : node) {
      for (double number : Numbers(element))
        numbers.push_back(number);
    }
  } else {
    Fail(node, "a list of numbers is expected");
  }
  return numbers;
}

void YamlFile::Fail(const YAML::Node& node, const std::string& message) const {
  throw InputError(Where(node) + ": " + message);
}

}  // namespace facet
