// SPDX-License-Identifier: BSD-2-Clause
#include "parameters.h"

#include <string>
#include <vector>

namespace facet {
namespace ros1 {

namespace {

/// ROS's parameter server.
class Server : public robot::ParameterSource {
 public:
  explicit Server(const ros::NodeHandle& node) : node_(node) {}

  bool Get(const std::string& name, bool& value) const override { return GetAny(name, value); }
  bool Get(const std::string& name, int& value) const override { return GetAny(name, value); }
  bool Get(const std::string& name, double& value) const override { return GetAny(name, value); }
  bool Get(const std::string& name, std::string& value) const override {
    return GetAny(name, value);
  }
  bool Get(const std::string& name, std::vector<double>& value) const override {
    return GetAny(name, value);
  }
  bool Get(const std::string& name, std::vector<std::string>& value) const override {
    return GetAny(name, value);
  }

  std::vector<std::string> Names() const override {
    std::vector<std::string> all, own;
    node_.getParamNames(all);
    const std::string prefix = node_.getNamespace() + "/";
    for (const std::string& name : all) {
      if (name.compare(0, prefix.size(), prefix) == 0) own.push_back(name.substr(prefix.size()));
    }
    return own;
  }

 private:
  template <class T>
  bool GetAny(const std::string& name, T& value) const {
    if (!node_.hasParam(name)) return false;
    if (!node_.getParam(name, value)) throw api::Error("~" + name + " is of the wrong type");
    return true;
  }

  const ros::NodeHandle& node_;
};

}  // namespace

robot::NodeParameters ReadParameters(const ros::NodeHandle& node) {
  return robot::ReadParameters(Server(node));
}

}  // namespace ros1
}  // namespace facet
