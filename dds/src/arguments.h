// SPDX-License-Identifier: BSD-2-Clause
// The command line of a node of ROS 2: names, and parameters with their values.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "facet/robot/node_parameters.h"

namespace YAML {
class Node;
}

namespace facet::dds {

/// Names of topics and services as ROS 2 resolves them, and as it calls them in DDS.
struct NodeNames {
  std::string node = "facet", space = "/";
  std::vector<std::pair<std::string, std::string>> remaps;  ///< from, to

  /// "left/image_raw" to "/left/image_raw", "~/pose" to "/facet/pose", remapped.
  std::string Resolve(const std::string& name) const;
  std::string Topic(const std::string& name) const { return "rt" + Resolve(name); }
  std::string Request(const std::string& name) const { return "rq" + Resolve(name) + "Request"; }
  std::string Reply(const std::string& name) const { return "rr" + Resolve(name) + "Reply"; }
};

/// Parameters as YAML: from --params-file and -p, the later ones count.
class YamlParameters : public robot::ParameterSource {
 public:
  YamlParameters();
  ~YamlParameters() override;
  YamlParameters(YamlParameters&&) noexcept;

  /// Nothing where `value` is empty. Throws api::Error where it is no YAML.
  void Set(const std::string& name, const std::string& value);
  /// What a file of ROS 2 has for the node: "/**" or its name, then "ros__parameters". Throws
  /// api::Error.
  void ReadFile(const std::string& file, const NodeNames& names);

  bool Get(const std::string& name, bool& value) const override;
  bool Get(const std::string& name, int& value) const override;
  bool Get(const std::string& name, double& value) const override;
  bool Get(const std::string& name, std::string& value) const override;
  bool Get(const std::string& name, std::vector<double>& value) const override;
  bool Get(const std::string& name, std::vector<std::string>& value) const override;
  /// Without those of the middleware.
  std::vector<std::string> Names() const override;

 private:
  void ReadNodes(const YAML::Node& root, const std::string& file, const NodeNames& names);

  struct Values;
  std::unique_ptr<Values> values_;
};

struct Arguments {
  NodeNames names;
  YamlParameters parameters;
  bool wants_help = false;
};

/// `words` are those behind the program's name. Throws api::Error.
Arguments ReadArguments(const std::vector<std::string>& words);

extern const char* const kUsageText;

}  // namespace facet::dds
