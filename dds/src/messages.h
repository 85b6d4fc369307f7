// SPDX-License-Identifier: BSD-2-Clause
// From the messages of ROS 2 to plain data, and back. Bytes of images are not copied. What is
// published points to names and texts of its arguments, which have to live until it is written.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "ros2_messages.h"

#include "facet/robot/image_pairer.h"
#include "facet/robot/marker.h"
#include "facet/robot/node_parameters.h"
#include "facet/robot/robot_output.h"

namespace facet::dds {

using Imu = sensor_msgs_msg_dds__Imu_;
using Image = sensor_msgs_msg_dds__Image_;
using CompressedImage = sensor_msgs_msg_dds__CompressedImage_;
using CameraInfo = sensor_msgs_msg_dds__CameraInfo_;
using PointCloud2 = sensor_msgs_msg_dds__PointCloud2_;
using PointField = sensor_msgs_msg_dds__PointField_;
using Header = std_msgs_msg_dds__Header_;
using ColorRGBA = std_msgs_msg_dds__ColorRGBA_;
using Point = geometry_msgs_msg_dds__Point_;
using Pose = geometry_msgs_msg_dds__Pose_;
using PoseStamped = geometry_msgs_msg_dds__PoseStamped_;
using PoseWithCovarianceStamped = geometry_msgs_msg_dds__PoseWithCovarianceStamped_;
using TransformStamped = geometry_msgs_msg_dds__TransformStamped_;
using Odometry = nav_msgs_msg_dds__Odometry_;
using Path = nav_msgs_msg_dds__Path_;
using Marker = visualization_msgs_msg_dds__Marker_;
using MarkerArray = visualization_msgs_msg_dds__MarkerArray_;
using TFMessage = tf2_msgs_msg_dds__TFMessage_;
using DiagnosticArray = diagnostic_msgs_msg_dds__DiagnosticArray_;
using DiagnosticStatus = diagnostic_msgs_msg_dds__DiagnosticStatus_;
using KeyValue = diagnostic_msgs_msg_dds__KeyValue_;
using TriggerRequest = std_srvs_srv_dds__Trigger_Request_;
using TriggerResponse = std_srvs_srv_dds__Trigger_Response_;

using robot::FrameNames;

// ---- what comes

api::ImuSample ToSample(const Imu& message);
/// The message lives as long as what it gives.
robot::ReceivedImage ToImage(const std::shared_ptr<const Image>& message);
robot::ReceivedImage ToImage(const std::shared_ptr<const CompressedImage>& message);
api::CameraInfo ToCameraInfo(const CameraInfo& message);

// ---- what is published

Odometry ToOdometry(const robot::OdometryOutput& output, const FrameNames& frames);
TransformStamped ToTransform(std::int64_t t_ns,
                             const std::string& parent,
                             const std::string& child,
                             const api::Pose& pose);
TFMessage ToTransforms(TransformStamped& transform);
PoseWithCovarianceStamped ToPose(const robot::PoseOutput& output, const FrameNames& frames);

/// A message with what it points to. Can be moved, because what vectors hold stays where it is, and
/// not copied.
struct PathMessage {
  PathMessage(const std::vector<robot::PathPose>& path, const FrameNames& frames);
  PathMessage(PathMessage&&) = default;
  std::vector<PoseStamped> poses;
  Path message{};
};

struct MarkerMessage {
  MarkerMessage(const robot::Marker& marker, const FrameNames& frames);
  MarkerMessage(MarkerMessage&&) = default;
  std::vector<Point> points;
  std::vector<ColorRGBA> colours;
  Marker message{};
};

struct MarkersMessage {
  MarkersMessage(const std::vector<robot::Marker>& markers, const FrameNames& frames);
  MarkersMessage(MarkersMessage&&) = default;
  std::vector<MarkerMessage> parts;
  std::vector<Marker> markers;
  MarkerArray message{};
};

/// The vertices of a mesh: x y z and, where they have colours, rgb.
struct PointsMessage {
  PointsMessage(const api::Mesh& mesh, const FrameNames& frames);
  PointsMessage(PointsMessage&&) = default;
  robot::PointRows rows;
  std::vector<PointField> fields;
  PointCloud2 message{};
};

struct DiagnosticMessage {
  DiagnosticMessage(const robot::Diagnosis& diagnosis, const std::string& node, std::int64_t t_ns);
  DiagnosticMessage(const DiagnosticMessage&) = delete;  // `message` points to `status`
  DiagnosticMessage& operator=(const DiagnosticMessage&) = delete;
  std::string name;
  std::vector<KeyValue> values;
  DiagnosticStatus status{};
  DiagnosticArray message{};
};

}  // namespace facet::dds
