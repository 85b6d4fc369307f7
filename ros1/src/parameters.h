// SPDX-License-Identifier: BSD-2-Clause
// The parameters of the node, in its private namespace.
#pragma once

#include <ros/node_handle.h>

#include "facet/robot/node_parameters.h"

namespace facet {
namespace ros1 {

/// Throws as robot::ReadParameters.
robot::NodeParameters ReadParameters(const ros::NodeHandle& node);

}  // namespace ros1
}  // namespace facet
