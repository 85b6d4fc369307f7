// SPDX-License-Identifier: BSD-2-Clause
// The counterpart of sensor_messages.h: the bytes of messages in CDR, little-endian, as ROS 2
// writes them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "facet/recording/sensor_messages.h"

namespace facet {

/// `grey` is 8-bit grey; the encoding becomes mono8.
std::vector<std::uint8_t> WriteImageMessage(const MessageHeader& header, const cv::Mat& grey);

/// The orientation is marked as unknown, covariances as zero, which means unknown, too.
std::vector<std::uint8_t> WriteImuMessage(const MessageHeader& header, const ImuSample& sample);

std::vector<std::uint8_t> WriteCameraInfoMessage(const CameraInfoMessage& info);

std::vector<std::uint8_t> WriteTransformsMessage(Timestamp t,
                                                 const std::vector<FrameTransform>& transforms);

/// The definition of a type and of those that it is made of, as MCAP wants it ("ros2msg"). `type`
/// is one of the names in sensor_messages.h, but not of compressed images; CHECKed.
std::string MessageDefinition(const std::string& type);

}  // namespace facet
