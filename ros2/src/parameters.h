// SPDX-License-Identifier: BSD-2-Clause
// The parameters of a node of ROS 2.
#pragma once

#include <string>
#include <vector>

#include <rclcpp/rclcpp.hpp>

#include "facet/robot/node_parameters.h"

namespace facet::ros2 {

/// Those that the node was started with. A whole number is a number, too.
class Parameters : public robot::ParameterSource {
 public:
  explicit Parameters(const rclcpp::Node& node) : node_(node) {}
  bool Get(const std::string& name, bool& value) const override { return Read(name, value); }
  bool Get(const std::string& name, int& value) const override { return Read(name, value); }
  bool Get(const std::string& name, double& value) const override {
    int whole = 0;
    if (node_.has_parameter(name) &&
        node_.get_parameter(name).get_type() == rclcpp::PARAMETER_INTEGER)
      return Read(name, whole) && (value = whole, true);
    return Read(name, value);
  }
  bool Get(const std::string& name, std::string& value) const override { return Read(name, value); }
  bool Get(const std::string& name, std::vector<double>& value) const override {
    return Read(name, value);
  }
  bool Get(const std::string& name, std::vector<std::string>& value) const override {
    return Read(name, value);
  }

  std::vector<std::string> Names() const override {
    std::vector<std::string> names;
    for (const std::string& name : node_.list_parameters({}, 0).names) {
      if (name != "use_sim_time" && name != "reliable" && name.rfind("qos_overrides.", 0) != 0)
        names.push_back(name);
    }
    return names;
  }

 private:
  template <class T>
  bool Read(const std::string& name, T& value) const {
    try {
      return node_.get_parameter(name, value);
    } catch (const rclcpp::ParameterTypeException&) {
      throw api::Error("~" + name + " is of the wrong type");
    }
  }

  const rclcpp::Node& node_;
};

}  // namespace facet::ros2
