// SPDX-License-Identifier: BSD-2-Clause
// The parameters of the node, in its private namespace.
#pragma once

#include <stdexcept>
#include <string>

#include "messages.h"
#include <ros/node_handle.h>

#include "facet/robot/robot_options.h"

namespace facet {
namespace ros1 {

struct Parameters {
  robot::RobotOptions robot;
  FrameNames frames;
  bool has_compressed_images = false;
  bool publishes_tf = true;      ///< odom to base
  bool publishes_map_tf = true;  ///< map to odom, the identity
  int imu_queue = 2000, image_queue = 40;
};

/// A calibration that cannot be read (exit code 3; what else is wrong is api::Error, code 2).
class CalibrationError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Throws api::Error, or CalibrationError, naming the parameter: also one that is not known.
Parameters ReadParameters(const ros::NodeHandle& node);

}  // namespace ros1
}  // namespace facet
