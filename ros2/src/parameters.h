// SPDX-License-Identifier: BSD-2-Clause
// The parameters of a node of ROS 2.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <rclcpp/rclcpp.hpp>

#include "facet/robot/node_parameters.h"

namespace facet::ros2 {

/// Those that the node was started with. Whole numbers are numbers, too.
class Parameters : public robot::ParameterSource {
 public:
  explicit Parameters(rclcpp::Node& node)
      : values_(node.get_node_parameters_interface()->get_parameter_overrides()) {}

  bool Get(const std::string& name, bool& value) const override { return Read<bool>(name, value); }
  bool Get(const std::string& name, int& value) const override {
    return Read<std::int64_t>(name, value);
  }
  bool Get(const std::string& name, double& value) const override {
    return Is(name, rclcpp::PARAMETER_INTEGER) ? Read<std::int64_t>(name, value)
                                               : Read<double>(name, value);
  }
  bool Get(const std::string& name, std::string& value) const override {
    return Read<std::string>(name, value);
  }
  bool Get(const std::string& name, std::vector<double>& value) const override {
    if (!Is(name, rclcpp::PARAMETER_INTEGER_ARRAY)) return Read<std::vector<double>>(name, value);
    std::vector<std::int64_t> whole;
    Read<std::vector<std::int64_t>>(name, whole);
    value.assign(whole.begin(), whole.end());
    return true;
  }
  bool Get(const std::string& name, std::vector<std::string>& value) const override {
    return Read<std::vector<std::string>>(name, value);
  }

  std::vector<std::string> Names() const override {
    std::vector<std::string> names;
    for (const auto& entry : values_) {
      if (!robot::IsOfMiddleware(entry.first)) names.push_back(entry.first);
    }
    return names;
  }

 private:
  bool Is(const std::string& name, rclcpp::ParameterType type) const {
    const auto found = values_.find(name);
    return found != values_.end() && found->second.get_type() == type;
  }

  template <class Stored, class T>
  bool Read(const std::string& name, T& value) const {
    const auto found = values_.find(name);
    if (found == values_.end()) return false;
    try {
      value = static_cast<T>(found->second.get<Stored>());
      return true;
    } catch (const rclcpp::ParameterTypeException&) {
      throw api::Error("~" + name + " is of the wrong type");
    }
  }

  const std::map<std::string, rclcpp::ParameterValue> values_;
};

}  // namespace facet::ros2
