// SPDX-License-Identifier: BSD-2-Clause
// The parameters of a node, by their names in ROS, wherever its middleware keeps them.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "facet/robot/robot_options.h"

namespace facet {
namespace robot {

/// REP 105.
struct FrameNames {
  std::string map = "map", odom = "odom", base = "base_link";
};

struct NodeParameters {
  RobotOptions robot;
  FrameNames frames;
  bool has_compressed_images = false;
  bool publishes_tf = true;      ///< odom to base
  bool publishes_map_tf = true;  ///< map to odom
  int imu_queue = 2000, image_queue = 40;
};

/// A calibration that cannot be read (exit code 3; what else is wrong is api::Error, code 2).
class CalibrationError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Where the parameters come from. Each function returns false where there is none of that name,
/// and throws api::Error where it is of another type.
class ParameterSource {
 public:
  virtual ~ParameterSource() = default;
  virtual bool Get(const std::string& name, bool& value) const = 0;
  virtual bool Get(const std::string& name, int& value) const = 0;
  virtual bool Get(const std::string& name, double& value) const = 0;
  virtual bool Get(const std::string& name, std::string& value) const = 0;
  virtual bool Get(const std::string& name, std::vector<double>& value) const = 0;
  virtual bool Get(const std::string& name, std::vector<std::string>& value) const = 0;
  /// Of all that are set.
  virtual std::vector<std::string> Names() const = 0;
};

/// Parameters that a middleware has besides those of the node: `reliable`, and what every node of
/// ROS 2 may have.
bool IsOfMiddleware(const std::string& name);

/// Throws api::Error, or CalibrationError, naming the parameter: also one that is not known.
NodeParameters ReadParameters(const ParameterSource& source);

}  // namespace robot
}  // namespace facet
