// SPDX-License-Identifier: BSD-2-Clause
// The messages of messages/ros_messages.h from the bytes of ROS 1 or CDR.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "facet/messages/ros_messages.h"
#include "facet/recording/message_source.h"

namespace facet {

inline constexpr const char* kImageType = "sensor_msgs/Image";
inline constexpr const char* kCompressedImageType = "sensor_msgs/CompressedImage";
inline constexpr const char* kImuType = "sensor_msgs/Imu";
inline constexpr const char* kCameraInfoType = "sensor_msgs/CameraInfo";
inline constexpr const char* kTransformsType = "tf2_msgs/TFMessage";

/// All of these throw InputError, without a place, when the bytes are too short or cannot be of the
/// type. They allocate no more than the bytes hold.
ImageMessage ReadImageMessage(std::span<const std::uint8_t> bytes, MessageEncoding encoding);
ImageMessage ReadCompressedImageMessage(std::span<const std::uint8_t> bytes,
                                        MessageEncoding encoding);
/// Of either type, which the topic says.
ImageMessage ReadAnyImageMessage(const Topic& topic, std::span<const std::uint8_t> bytes);
ImuMessage ReadImuMessage(std::span<const std::uint8_t> bytes, MessageEncoding encoding);
CameraInfoMessage ReadCameraInfoMessage(std::span<const std::uint8_t> bytes,
                                        MessageEncoding encoding);
/// Rotations are normalised; throws for those that cannot be.
std::vector<FrameTransform> ReadTransformsMessage(std::span<const std::uint8_t> bytes,
                                                  MessageEncoding encoding);

}  // namespace facet
