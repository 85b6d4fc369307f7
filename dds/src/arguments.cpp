// SPDX-License-Identifier: BSD-2-Clause
#include "arguments.h"

#include <algorithm>
#include <string_view>

#include <yaml-cpp/yaml.h>

#include "facet/facet.h"

namespace facet::dds {

const char* const kUsageText =
    "usage: facet-dds [--ros-args] [-p NAME:=VALUE]... [--params-file FILE]... [-r FROM:=TO]...\n"
    "\n"
    "Facet as a node of ROS 2 on Cyclone DDS: stereo images and IMU to odometry, mesh, map and "
    "planes.\n"
    "  -p, --param NAME:=VALUE   a parameter, in YAML, for example calibration:=camchain.yaml\n"
    "  --params-file FILE        parameters of ROS 2's form\n"
    "  -r, --remap FROM:=TO      a topic by another name; __node:=NAME and __ns:=/SPACE name the "
    "node\n"
    "ROS_DOMAIN_ID and CYCLONEDDS_URI count as for any node. Topics and parameters: docs/ros.md.\n";

namespace {

constexpr std::string_view kAssign = ":=";

std::pair<std::string, std::string> Split(const std::string& rule, const std::string& option) {
  const std::size_t at = rule.find(kAssign);
  if (at == std::string::npos || at == 0)
    throw api::Error(option + " " + rule + ": NAME:=VALUE is wanted");
  return {rule.substr(0, at), rule.substr(at + kAssign.size())};
}

std::string Absolute(const std::string& name, const NodeNames& names) {
  const std::string space = names.space == "/" ? "" : names.space;
  if (name.front() == '/') return name;
  if (name.front() == '~') return space + "/" + names.node + name.substr(1);
  return space + "/" + name;
}

void AddRemap(NodeNames& names, const std::pair<std::string, std::string>& rule) {
  const auto& [from, to] = rule;
  if (to.empty()) throw api::Error("-r " + from + ":=: a name is wanted");
  if (from == "__node" || from == "__name") {
    names.node = to;
  } else if (from == "__ns") {
    if (to.front() != '/') throw api::Error("-r __ns:=" + to + ": a namespace begins with /");
    names.space = to;
  } else {
    names.remaps.push_back(rule);
  }
}

}  // namespace

std::string NodeNames::Resolve(const std::string& name) const {
  const std::string absolute = Absolute(name, *this);
  for (const auto& [from, to] : remaps) {
    if (Absolute(from, *this) == absolute) return Absolute(to, *this);
  }
  return absolute;
}

struct YamlParameters::Values {
  std::map<std::string, YAML::Node> nodes;

  template <class T>
  bool Get(const std::string& name, T& value, const char* wanted) const {
    const auto found = nodes.find(name);
    if (found == nodes.end()) return false;
    try {
      value = found->second.as<T>();
      return true;
    } catch (const YAML::Exception&) {
      throw api::Error("~" + name + " is of the wrong type: " + wanted + " is wanted");
    }
  }
};

YamlParameters::YamlParameters() : values_(std::make_unique<Values>()) {}
YamlParameters::~YamlParameters() = default;
YamlParameters::YamlParameters(YamlParameters&&) noexcept = default;

void YamlParameters::Set(const std::string& name, const std::string& value) {
  try {
    const YAML::Node node = YAML::Load(value);
    if (!node.IsNull()) values_->nodes[name] = node;
  } catch (const YAML::Exception& error) {
    throw api::Error("-p " + name + ":=" + value + ": " + error.what());
  }
}

void YamlParameters::ReadFile(const std::string& file, const NodeNames& names) {
  try {
    ReadNodes(YAML::LoadFile(file), file, names);
  } catch (const YAML::Exception& error) {
    throw api::Error(file + ": " + error.what());
  }
}

void YamlParameters::ReadNodes(const YAML::Node& root,
                               const std::string& file,
                               const NodeNames& names) {
  if (!root.IsMap()) throw api::Error(file + ": a map of nodes is wanted");
  bool is_for_us = false;
  for (const std::string& key : {std::string("/**"), names.node, Absolute(names.node, names)}) {
    const YAML::Node node = root[key];
    if (!node.IsDefined()) continue;
    const YAML::Node own = node.IsMap() ? node["ros__parameters"] : YAML::Node();
    if (!own.IsMap()) throw api::Error(file + ": " + key + " has no ros__parameters");
    is_for_us = true;
    for (const auto& entry : own) {
      if (!entry.second.IsNull()) values_->nodes[entry.first.as<std::string>()] = entry.second;
    }
  }
  if (!is_for_us) throw api::Error(file + ": nothing for a node \"" + names.node + "\" or \"/**\"");
}

bool YamlParameters::Get(const std::string& name, bool& value) const {
  return values_->Get(name, value, "true or false");
}

bool YamlParameters::Get(const std::string& name, int& value) const {
  return values_->Get(name, value, "a whole number");
}

bool YamlParameters::Get(const std::string& name, double& value) const {
  return values_->Get(name, value, "a number");
}

bool YamlParameters::Get(const std::string& name, std::string& value) const {
  return values_->Get(name, value, "a text");
}

bool YamlParameters::Get(const std::string& name, std::vector<double>& value) const {
  return values_->Get(name, value, "a list of numbers");
}

bool YamlParameters::Get(const std::string& name, std::vector<std::string>& value) const {
  return values_->Get(name, value, "a list of texts");
}

std::vector<std::string> YamlParameters::Names() const {
  std::vector<std::string> names;
  for (const auto& [name, node] : values_->nodes) {
    if (!robot::IsOfMiddleware(name)) names.push_back(name);
  }
  return names;
}

Arguments ReadArguments(const std::vector<std::string>& words) {
  Arguments arguments;
  // Which parameters of a file count depends on the node's name, which may come later.
  std::vector<std::pair<std::string, std::string>> set;
  std::vector<std::string> files;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    if (word == "--ros-args" || word == "--") continue;
    if (word == "-h" || word == "--help") {
      arguments.wants_help = true;
      return arguments;
    }
    const bool is_param = word == "-p" || word == "--param";
    const bool is_remap = word == "-r" || word == "--remap";
    const bool is_file = word == "--params-file";
    if (!is_param && !is_remap && !is_file && word.find(kAssign) == std::string::npos)
      throw api::Error("\"" + word + "\" is no argument; --help tells which there are");
    if (is_param || is_remap || is_file) {
      if (++i == words.size()) throw api::Error(word + ": something is missing behind it");
    }
    if (is_param) {
      set.push_back(Split(words[i], word));
    } else if (is_file) {
      files.push_back(words[i]);
    } else {
      AddRemap(arguments.names, Split(words[i], "-r"));
    }
  }
  for (const std::string& file : files)
    arguments.parameters.ReadFile(file, arguments.names);
  for (const auto& [name, value] : set)
    arguments.parameters.Set(name, value);
  return arguments;
}

}  // namespace facet::dds
