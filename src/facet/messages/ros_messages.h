// SPDX-License-Identifier: BSD-2-Clause
// The few ROS messages that a stereo-inertial rig sends, as plain data: from a bag, or live.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "facet/base/types.h"
#include "facet/geometry/se3.h"
#include "facet/imu/imu_types.h"

namespace facet {

struct MessageHeader {
  Timestamp t;
  std::string frame;
};

/// sensor_msgs/Image, or CompressedImage: then `encoding` is empty and the data are a file.
struct ImageMessage {
  MessageHeader header;
  std::uint32_t width = 0, height = 0;  ///< 0 if compressed
  std::string encoding;                 ///< mono8, bgr8, ...
  bool is_big_endian = false;
  std::uint32_t step = 0;              ///< bytes per row
  std::span<const std::uint8_t> data;  ///< lies in the bytes of the message
};

/// sensor_msgs/CameraInfo without its regions and binning.
struct CameraInfoMessage {
  MessageHeader header;
  std::uint32_t width = 0, height = 0;
  std::string distortion_model;  ///< plumb_bob, equidistant, ...
  std::vector<double> D;
  std::array<double, 9> K{};   ///< of the raw image, row by row
  std::array<double, 9> R{};   ///< from the raw to the rectified camera, row by row
  std::array<double, 12> P{};  ///< of the rectified image, row by row
};

/// One transform of tf2_msgs/TFMessage: maps points from the child frame to the parent frame.
struct FrameTransform {
  std::string parent, child;
  SE3 T_parent_child;
};

/// Angular velocity [rad/s], linear acceleration [m/s^2], in the sensor's frame; numbers may be
/// anything, also not finite.
struct ImuMessage {
  MessageHeader header;
  ImuSample sample;
};

}  // namespace facet
