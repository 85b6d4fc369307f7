// SPDX-License-Identifier: BSD-2-Clause
#include "messages.h"

#include <algorithm>
#include <utility>

namespace facet::dds {

namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr std::uint8_t kFloat32 = 7;  // sensor_msgs/PointField

// The bindings for C have texts that could be written to. Nothing writes to them on the way out.
char* Borrowed(const char* text) {
  return const_cast<char*>(text);
}

char* Borrowed(const std::string& text) {
  return Borrowed(text.c_str());
}

/// A sequence that owns nothing.
template <class Sequence, class T>
void Borrow(Sequence& sequence, std::vector<T>& values) {
  sequence._maximum = sequence._length = static_cast<std::uint32_t>(values.size());
  sequence._buffer = values.data();
  sequence._release = false;
}

/// Null where a message was never filled.
std::string TextOf(const char* text) {
  return text == nullptr ? std::string() : std::string(text);
}

std::int64_t Nanoseconds(const builtin_interfaces_msg_dds__Time_& time) {
  return time.sec * kSecond_ns + time.nanosec;
}

Header HeaderOf(std::int64_t t_ns, const std::string& frame) {
  const std::int64_t stamp = std::max<std::int64_t>(t_ns, 0);
  Header header{};
  header.stamp.sec = static_cast<std::int32_t>(stamp / kSecond_ns);
  header.stamp.nanosec = static_cast<std::uint32_t>(stamp % kSecond_ns);
  header.frame_id = Borrowed(frame);
  return header;
}

api::Vec3 ToVec3(const geometry_msgs_msg_dds__Vector3_& v) {
  return {{v.x, v.y, v.z}};
}

geometry_msgs_msg_dds__Vector3_ ToVector(const api::Vec3& v) {
  return {v[0], v[1], v[2]};
}

Point ToPoint(const api::Vec3& v) {
  return {v[0], v[1], v[2]};
}

geometry_msgs_msg_dds__Quaternion_ ToQuaternion(const std::array<double, 4>& wxyz) {
  return {wxyz[1], wxyz[2], wxyz[3], wxyz[0]};
}

Pose ToPoseMessage(const api::Pose& pose) {
  return {ToPoint(pose.p), ToQuaternion(pose.q)};
}

ColorRGBA ToColour(const robot::Colour& c) {
  return {c[0], c[1], c[2], c[3]};
}

/// With the bytes of the message, which stays as long as the image.
template <class Message>
robot::ReceivedImage Received(const std::shared_ptr<const Message>& message,
                              api::EncodedImage image) {
  image.bytes = message->data._buffer;
  image.num_bytes = message->data._length;
  return {Nanoseconds(message->header.stamp), image, message};
}

PointField Field(const char* name, std::uint32_t number) {
  return {Borrowed(name), number * static_cast<std::uint32_t>(sizeof(float)), kFloat32, 1};
}

}  // namespace

api::ImuSample ToSample(const Imu& message) {
  return {Nanoseconds(message.header.stamp),
          ToVec3(message.angular_velocity),
          ToVec3(message.linear_acceleration)};
}

robot::ReceivedImage ToImage(const std::shared_ptr<const Image>& message) {
  api::EncodedImage image;
  // What has none is no file, which an empty one would say.
  image.encoding = TextOf(message->encoding);
  if (image.encoding.empty()) image.encoding = "none";
  image.width = static_cast<int>(std::min<std::uint32_t>(message->width, INT32_MAX));
  image.height = static_cast<int>(std::min<std::uint32_t>(message->height, INT32_MAX));
  image.step_bytes = message->step;
  image.is_big_endian = message->is_bigendian != 0;
  return Received(message, std::move(image));
}

robot::ReceivedImage ToImage(const std::shared_ptr<const CompressedImage>& message) {
  return Received(message, {});
}

api::CameraInfo ToCameraInfo(const CameraInfo& message) {
  api::CameraInfo info;
  info.width = static_cast<int>(std::min<std::uint32_t>(message.width, INT32_MAX));
  info.height = static_cast<int>(std::min<std::uint32_t>(message.height, INT32_MAX));
  info.distortion_model = TextOf(message.distortion_model);
  info.D.assign(message.d._buffer, message.d._buffer + message.d._length);
  std::copy(std::begin(message.k), std::end(message.k), info.K.begin());
  std::copy(std::begin(message.r), std::end(message.r), info.R.begin());
  std::copy(std::begin(message.p), std::end(message.p), info.P.begin());
  return info;
}

Odometry ToOdometry(const robot::OdometryOutput& output, const FrameNames& frames) {
  Odometry message{};
  message.header = HeaderOf(output.t_ns, frames.odom);
  message.child_frame_id = Borrowed(frames.base);
  message.pose.pose = ToPoseMessage(output.T_odom_base);
  message.twist.twist.linear = ToVector(output.v_base);
  message.twist.twist.angular = ToVector(output.w_base);
  std::copy(output.pose_covariance.begin(), output.pose_covariance.end(), message.pose.covariance);
  std::copy(
      output.twist_covariance.begin(), output.twist_covariance.end(), message.twist.covariance);
  return message;
}

TransformStamped ToTransform(std::int64_t t_ns,
                             const std::string& parent,
                             const std::string& child,
                             const api::Pose& pose) {
  TransformStamped transform{};
  transform.header = HeaderOf(t_ns, parent);
  transform.child_frame_id = Borrowed(child);
  transform.transform.translation = ToVector(pose.p);
  transform.transform.rotation = ToQuaternion(pose.q);
  return transform;
}

TFMessage ToTransforms(TransformStamped& transform) {
  TFMessage message{};
  message.transforms._maximum = message.transforms._length = 1;
  message.transforms._buffer = &transform;
  return message;
}

PoseWithCovarianceStamped ToPose(const robot::PoseOutput& output, const FrameNames& frames) {
  PoseWithCovarianceStamped message{};
  message.header = HeaderOf(output.t_ns, frames.odom);
  message.pose.pose = ToPoseMessage(output.T_odom_base);
  std::copy(output.covariance.begin(), output.covariance.end(), message.pose.covariance);
  return message;
}

PathMessage::PathMessage(const std::vector<robot::PathPose>& path, const FrameNames& frames) {
  poses.reserve(path.size());
  for (const robot::PathPose& pose : path)
    poses.push_back({HeaderOf(pose.t_ns, frames.odom), ToPoseMessage(pose.T_odom_base)});
  message.header = HeaderOf(path.empty() ? 0 : path.back().t_ns, frames.odom);
  Borrow(message.poses, poses);
}

MarkerMessage::MarkerMessage(const robot::Marker& marker, const FrameNames& frames) {
  points.reserve(marker.points.size());
  for (const api::Vec3& point : marker.points)
    points.push_back(ToPoint(point));
  colours.reserve(marker.colours.size());
  for (const robot::Colour& colour : marker.colours)
    colours.push_back(ToColour(colour));
  message.header = HeaderOf(marker.t_ns, frames.odom);
  message.ns = Borrowed(marker.name);
  message.id = marker.id;
  message.type = marker.type;
  message.action = marker.action;
  message.pose.position = ToPoint(marker.position);
  message.pose.orientation.w = 1;
  message.scale = ToVector(marker.scale);
  message.color = ToColour(marker.colour);
  message.frame_locked = true;
  Borrow(message.points, points);
  Borrow(message.colors, colours);
  message.text = Borrowed(marker.text);
  // Nothing has a texture, and there is no file.
  message.texture.header = HeaderOf(0, frames.odom);
  message.texture_resource = message.texture.format = message.mesh_resource = Borrowed("");
  message.mesh_file.filename = Borrowed("");
}

MarkersMessage::MarkersMessage(const std::vector<robot::Marker>& from, const FrameNames& frames) {
  parts.reserve(from.size());
  for (const robot::Marker& marker : from) {
    parts.emplace_back(marker, frames);
    markers.push_back(parts.back().message);
  }
  Borrow(message.markers, markers);
}

PointsMessage::PointsMessage(const api::Mesh& mesh, const FrameNames& frames)
    : rows(robot::ToPointRows(mesh)), fields{Field("x", 0), Field("y", 1), Field("z", 2)} {
  if (rows.has_colours) fields.push_back(Field("rgb", 3));
  message.header = HeaderOf(mesh.t_ns, frames.odom);
  message.height = 1;
  message.width = rows.num_points;
  Borrow(message.fields, fields);
  message.point_step = rows.bytes_per_point;
  message.row_step = rows.bytes_per_point * rows.num_points;
  Borrow(message.data, rows.bytes);
  message.is_dense = true;
}

DiagnosticMessage::DiagnosticMessage(const robot::Diagnosis& diagnosis,
                                     const std::string& node,
                                     std::int64_t t_ns)
    : name(node + ": odometry") {
  values.reserve(diagnosis.values.size());
  for (const auto& [key, value] : diagnosis.values)
    values.push_back({Borrowed(key), Borrowed(value)});
  status.level = static_cast<std::uint8_t>(diagnosis.level);
  status.name = Borrowed(name);
  status.message = Borrowed(diagnosis.summary);
  status.hardware_id = Borrowed("facet");
  Borrow(status.values, values);
  static const std::string kNoFrame;
  message.header = HeaderOf(t_ns, kNoFrame);
  message.status._maximum = message.status._length = 1;
  message.status._buffer = &status;
}

}  // namespace facet::dds
