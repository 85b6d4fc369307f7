// SPDX-License-Identifier: BSD-2-Clause
// From messages of ROS to plain data, and back. ROS 1 and ROS 2 have the same messages, as classes
// of different names: the functions here are for both. What differs is the stamp, and the letters
// of a CameraInfo. Bytes of images are not copied.
//
//   nav_msgs::Odometry message = robot::ToOdometry<nav_msgs::Odometry>(output, frames);         //
//   ROS 1 auto message = robot::ToOdometry<nav_msgs::msg::Odometry>(output, frames); // ROS 2
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "facet/robot/image_pairer.h"
#include "facet/robot/marker.h"
#include "facet/robot/node_parameters.h"
#include "facet/robot/robot_output.h"

namespace facet {
namespace robot {

namespace message_parts {

constexpr std::int64_t kSecond_ns = 1000000000;

// ---- what differs: sec and nsec in ROS 1, sec and nanosec in ROS 2; K and k, ...

template <class Stamp>
auto Fraction(Stamp& stamp) -> decltype((stamp.nsec)) {
  return stamp.nsec;
}

template <class Stamp>
auto Fraction(Stamp& stamp) -> decltype((stamp.nanosec)) {
  return stamp.nanosec;
}

template <class Info>
auto CopyMatrices(const Info& from, api::CameraInfo& to) -> decltype(from.K, void()) {
  to.D.assign(from.D.begin(), from.D.end());
  std::copy(from.K.begin(), from.K.end(), to.K.begin());
  std::copy(from.R.begin(), from.R.end(), to.R.begin());
  std::copy(from.P.begin(), from.P.end(), to.P.begin());
}

template <class Info>
auto CopyMatrices(const Info& from, api::CameraInfo& to) -> decltype(from.k, void()) {
  to.D.assign(from.d.begin(), from.d.end());
  std::copy(from.k.begin(), from.k.end(), to.K.begin());
  std::copy(from.r.begin(), from.r.end(), to.R.begin());
  std::copy(from.p.begin(), from.p.end(), to.P.begin());
}

// ---- what is the same

template <class Stamp>
std::int64_t Nanoseconds(const Stamp& stamp) {
  return stamp.sec * kSecond_ns + static_cast<std::int64_t>(Fraction(stamp));
}

template <class Header>
void SetHeader(Header& header, std::int64_t t_ns, const std::string& frame) {
  const std::int64_t stamp = std::max<std::int64_t>(t_ns, 0);
  header.stamp.sec = static_cast<decltype(header.stamp.sec)>(stamp / kSecond_ns);
  Fraction(header.stamp) = static_cast<std::uint32_t>(stamp % kSecond_ns);
  header.frame_id = frame;
}

template <class Vector>
api::Vec3 ToVec3(const Vector& v) {
  return {{v.x, v.y, v.z}};
}

template <class Vector>
void Set(Vector& to, const api::Vec3& v) {
  to.x = v[0];
  to.y = v[1];
  to.z = v[2];
}

template <class Quaternion>
void SetRotation(Quaternion& to, const std::array<double, 4>& wxyz) {
  to.w = wxyz[0];
  to.x = wxyz[1];
  to.y = wxyz[2];
  to.z = wxyz[3];
}

template <class Pose>
void SetPose(Pose& to, const api::Pose& pose) {
  Set(to.position, pose.p);
  SetRotation(to.orientation, pose.q);
}

template <class Colour>
void SetColour(Colour& to, const robot::Colour& c) {
  to.r = c[0];
  to.g = c[1];
  to.b = c[2];
  to.a = c[3];
}

/// With the bytes of the message, which stays as long as the image.
template <class Pointer>
ReceivedImage Received(const Pointer& message, api::EncodedImage image) {
  image.bytes = message->data.data();
  image.num_bytes = message->data.size();
  return {Nanoseconds(message->header.stamp),
          image,
          std::shared_ptr<const void>(message->data.data(), [message](const void*) {})};
}

}  // namespace message_parts

// ---- what comes

/// sensor_msgs/Imu.
template <class Message>
api::ImuSample ToSample(const Message& message) {
  return {message_parts::Nanoseconds(message.header.stamp),
          message_parts::ToVec3(message.angular_velocity),
          message_parts::ToVec3(message.linear_acceleration)};
}

/// sensor_msgs/Image, by a shared pointer. The message lives as long as what it gives.
template <class Pointer>
ReceivedImage ToRawImage(const Pointer& message) {
  api::EncodedImage image;
  // What has none is no file, which an empty one would say.
  image.encoding = message->encoding.empty() ? "none" : message->encoding;
  image.width = static_cast<int>(std::min<std::uint32_t>(message->width, INT32_MAX));
  image.height = static_cast<int>(std::min<std::uint32_t>(message->height, INT32_MAX));
  image.step_bytes = message->step;
  image.is_big_endian = message->is_bigendian != 0;
  return message_parts::Received(message, std::move(image));
}

/// sensor_msgs/CompressedImage, likewise.
template <class Pointer>
ReceivedImage ToCompressedImage(const Pointer& message) {
  return message_parts::Received(message, {});
}

template <class Message>
api::CameraInfo ToCameraInfo(const Message& message) {
  api::CameraInfo info;
  info.width = static_cast<int>(std::min<std::uint32_t>(message.width, INT32_MAX));
  info.height = static_cast<int>(std::min<std::uint32_t>(message.height, INT32_MAX));
  info.distortion_model = message.distortion_model;
  message_parts::CopyMatrices(message, info);
  return info;
}

// ---- what is published

/// nav_msgs/Odometry.
template <class Message>
Message ToOdometry(const OdometryOutput& output, const FrameNames& frames) {
  Message message;
  message_parts::SetHeader(message.header, output.t_ns, frames.odom);
  message.child_frame_id = frames.base;
  message_parts::SetPose(message.pose.pose, output.T_odom_base);
  message_parts::Set(message.twist.twist.linear, output.v_base);
  message_parts::Set(message.twist.twist.angular, output.w_base);
  std::copy(output.pose_covariance.begin(),
            output.pose_covariance.end(),
            message.pose.covariance.begin());
  std::copy(output.twist_covariance.begin(),
            output.twist_covariance.end(),
            message.twist.covariance.begin());
  return message;
}

/// tf2_msgs/TFMessage with one transform.
template <class Message>
Message ToTransforms(std::int64_t t_ns,
                     const std::string& parent,
                     const std::string& child,
                     const api::Pose& pose) {
  Message message;
  message.transforms.resize(1);
  auto& transform = message.transforms.front();
  message_parts::SetHeader(transform.header, t_ns, parent);
  transform.child_frame_id = child;
  message_parts::Set(transform.transform.translation, pose.p);
  message_parts::SetRotation(transform.transform.rotation, pose.q);
  return message;
}

/// geometry_msgs/PoseWithCovarianceStamped.
template <class Message>
Message ToPose(const PoseOutput& output, const FrameNames& frames) {
  Message message;
  message_parts::SetHeader(message.header, output.t_ns, frames.odom);
  message_parts::SetPose(message.pose.pose, output.T_odom_base);
  std::copy(output.covariance.begin(), output.covariance.end(), message.pose.covariance.begin());
  return message;
}

/// nav_msgs/Path.
template <class Message>
Message ToPath(const std::vector<PathPose>& path, const FrameNames& frames) {
  Message message;
  message_parts::SetHeader(message.header, path.empty() ? 0 : path.back().t_ns, frames.odom);
  message.poses.resize(path.size());
  for (std::size_t i = 0; i < path.size(); ++i) {
    message_parts::SetHeader(message.poses[i].header, path[i].t_ns, frames.odom);
    message_parts::SetPose(message.poses[i].pose, path[i].T_odom_base);
  }
  return message;
}

/// visualization_msgs/Marker.
template <class Message>
Message ToMarker(const Marker& marker, const FrameNames& frames) {
  Message message;
  message_parts::SetHeader(message.header, marker.t_ns, frames.odom);
  message.ns = marker.name;
  message.id = marker.id;
  message.type = marker.type;
  message.action = marker.action;
  message_parts::Set(message.pose.position, marker.position);
  message.pose.orientation.w = 1;
  message_parts::Set(message.scale, marker.scale);
  message_parts::SetColour(message.color, marker.colour);
  message.frame_locked = true;
  message.text = marker.text;
  message.points.resize(marker.points.size());
  for (std::size_t i = 0; i < marker.points.size(); ++i)
    message_parts::Set(message.points[i], marker.points[i]);
  message.colors.resize(marker.colours.size());
  for (std::size_t i = 0; i < marker.colours.size(); ++i)
    message_parts::SetColour(message.colors[i], marker.colours[i]);
  return message;
}

/// visualization_msgs/MarkerArray.
template <class Message>
Message ToMarkers(const std::vector<Marker>& markers, const FrameNames& frames) {
  using One = typename decltype(Message::markers)::value_type;
  Message message;
  for (const Marker& marker : markers)
    message.markers.push_back(ToMarker<One>(marker, frames));
  return message;
}

/// sensor_msgs/PointCloud2: the vertices of a mesh, x y z and, where they have colours, rgb.
template <class Message>
Message ToPoints(const api::Mesh& mesh, const FrameNames& frames) {
  constexpr std::uint8_t kFloat32 = 7;
  const std::array<const char*, 4> names = {{"x", "y", "z", "rgb"}};
  PointRows rows = ToPointRows(mesh);
  Message message;
  message_parts::SetHeader(message.header, mesh.t_ns, frames.odom);
  message.height = 1;
  message.width = rows.num_points;
  message.fields.resize(rows.has_colours ? 4 : 3);
  for (std::size_t i = 0; i < message.fields.size(); ++i) {
    message.fields[i].name = names[i];
    message.fields[i].offset = static_cast<std::uint32_t>(i * sizeof(float));
    message.fields[i].datatype = kFloat32;
    message.fields[i].count = 1;
  }
  message.point_step = rows.bytes_per_point;
  message.row_step = rows.bytes_per_point * rows.num_points;
  message.data = std::move(rows.bytes);
  message.is_dense = true;
  return message;
}

/// diagnostic_msgs/DiagnosticArray of one status, without its stamp, which is the machine's time.
template <class Message>
Message ToDiagnostics(const Diagnosis& diagnosis, const std::string& node) {
  Message message;
  message.status.resize(1);
  auto& status = message.status.front();
  status.level = static_cast<decltype(status.level)>(diagnosis.level);
  status.name = node + ": odometry";
  status.hardware_id = "facet";
  status.message = diagnosis.summary;
  for (const auto& value : diagnosis.values) {
    status.values.emplace_back();
    status.values.back().key = value.first;
    status.values.back().value = value.second;
  }
  return message;
}

}  // namespace robot
}  // namespace facet
