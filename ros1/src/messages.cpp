// SPDX-License-Identifier: BSD-2-Clause
#include "messages.h"

#include <algorithm>
#include <array>
#include <utility>

namespace facet {
namespace ros1 {

namespace {

using visualization_msgs::Marker;

std::int64_t Nanoseconds(const ros::Time& time) {
  return static_cast<std::int64_t>(time.toNSec());
}

api::Vec3 ToVec3(const geometry_msgs::Vector3& v) {
  return {{v.x, v.y, v.z}};
}

geometry_msgs::Vector3 ToVector(const api::Vec3& v) {
  geometry_msgs::Vector3 vector;
  vector.x = v[0];
  vector.y = v[1];
  vector.z = v[2];
  return vector;
}

geometry_msgs::Point ToPoint(const api::Vec3& v) {
  geometry_msgs::Point point;
  point.x = v[0];
  point.y = v[1];
  point.z = v[2];
  return point;
}

geometry_msgs::Quaternion ToQuaternion(const std::array<double, 4>& wxyz) {
  geometry_msgs::Quaternion q;
  q.w = wxyz[0];
  q.x = wxyz[1];
  q.y = wxyz[2];
  q.z = wxyz[3];
  return q;
}

std_msgs::ColorRGBA ToColour(const robot::Colour& c) {
  std_msgs::ColorRGBA colour;
  colour.r = c[0];
  colour.g = c[1];
  colour.b = c[2];
  colour.a = c[3];
  return colour;
}

sensor_msgs::PointField Field(const char* name, std::uint32_t offset) {
  sensor_msgs::PointField field;
  field.name = name;
  field.offset = offset;
  field.datatype = sensor_msgs::PointField::FLOAT32;
  field.count = 1;
  return field;
}

/// With the bytes of the message, which stays as long as the image.
template <class Message>
robot::ReceivedImage Received(const Message& message, api::EncodedImage image) {
  image.bytes = message->data.data();
  image.num_bytes = message->data.size();
  return {Nanoseconds(message->header.stamp),
          image,
          std::shared_ptr<const void>(message->data.data(), [message](const void*) {})};
}

template <class From, class To>
void Copy(const From& from, To& to) {
  std::copy(from.begin(), from.end(), to.begin());
}

}  // namespace

api::ImuSample ToSample(const sensor_msgs::Imu& message) {
  return {Nanoseconds(message.header.stamp),
          ToVec3(message.angular_velocity),
          ToVec3(message.linear_acceleration)};
}

robot::ReceivedImage ToImage(const sensor_msgs::ImageConstPtr& message) {
  api::EncodedImage image;
  // What has none is no file, which an empty one would say.
  image.encoding = message->encoding.empty() ? "none" : message->encoding;
  image.width = static_cast<int>(std::min<std::uint32_t>(message->width, INT32_MAX));
  image.height = static_cast<int>(std::min<std::uint32_t>(message->height, INT32_MAX));
  image.step_bytes = message->step;
  image.is_big_endian = message->is_bigendian != 0;
  return Received(message, std::move(image));
}

robot::ReceivedImage ToImage(const sensor_msgs::CompressedImageConstPtr& message) {
  return Received(message, {});
}

api::CameraInfo ToCameraInfo(const sensor_msgs::CameraInfo& message) {
  api::CameraInfo info;
  info.width = static_cast<int>(std::min<std::uint32_t>(message.width, INT32_MAX));
  info.height = static_cast<int>(std::min<std::uint32_t>(message.height, INT32_MAX));
  info.distortion_model = message.distortion_model;
  info.D = message.D;
  Copy(message.K, info.K);
  Copy(message.R, info.R);
  Copy(message.P, info.P);
  return info;
}

ros::Time ToTime(std::int64_t t_ns) {
  return ros::Time().fromNSec(static_cast<std::uint64_t>(std::max<std::int64_t>(t_ns, 0)));
}

std_msgs::Header Header(std::int64_t t_ns, const std::string& frame) {
  std_msgs::Header header;
  header.stamp = ToTime(t_ns);
  header.frame_id = frame;
  return header;
}

geometry_msgs::Pose ToPose(const api::Pose& pose) {
  geometry_msgs::Pose message;
  message.position = ToPoint(pose.p);
  message.orientation = ToQuaternion(pose.q);
  return message;
}

geometry_msgs::TransformStamped ToTransform(std_msgs::Header header,
                                            const std::string& child,
                                            const api::Pose& pose) {
  geometry_msgs::TransformStamped transform;
  transform.header = std::move(header);
  transform.child_frame_id = child;
  transform.transform.translation = ToVector(pose.p);
  transform.transform.rotation = ToQuaternion(pose.q);
  return transform;
}

nav_msgs::Odometry ToOdometry(const robot::OdometryOutput& output, const FrameNames& frames) {
  nav_msgs::Odometry message;
  message.header = Header(output.t_ns, frames.odom);
  message.child_frame_id = frames.base;
  message.pose.pose = ToPose(output.T_odom_base);
  message.twist.twist.linear = ToVector(output.v_base);
  message.twist.twist.angular = ToVector(output.w_base);
  Copy(output.pose_covariance, message.pose.covariance);
  Copy(output.twist_covariance, message.twist.covariance);
  return message;
}

geometry_msgs::PoseWithCovarianceStamped ToPose(const robot::PoseOutput& output,
                                                const FrameNames& frames) {
  geometry_msgs::PoseWithCovarianceStamped message;
  message.header = Header(output.t_ns, frames.odom);
  message.pose.pose = ToPose(output.T_odom_base);
  Copy(output.covariance, message.pose.covariance);
  return message;
}

nav_msgs::Path ToPath(const std::vector<robot::PathPose>& path, const FrameNames& frames) {
  nav_msgs::Path message;
  message.header = Header(path.empty() ? 0 : path.back().t_ns, frames.odom);
  message.poses.reserve(path.size());
  for (const robot::PathPose& pose : path) {
    geometry_msgs::PoseStamped stamped;
    stamped.header = Header(pose.t_ns, frames.odom);
    stamped.pose = ToPose(pose.T_odom_base);
    message.poses.push_back(stamped);
  }
  return message;
}

Marker ToMarker(const robot::Marker& marker, const FrameNames& frames) {
  Marker message;
  message.header = Header(marker.t_ns, frames.odom);
  message.ns = marker.name;
  message.id = marker.id;
  message.type = marker.type;
  message.action = marker.action;
  message.pose.position = ToPoint(marker.position);
  message.pose.orientation.w = 1;
  message.scale = ToVector(marker.scale);
  message.color = ToColour(marker.colour);
  message.frame_locked = true;
  message.text = marker.text;
  message.points.reserve(marker.points.size());
  for (const api::Vec3& point : marker.points)
    message.points.push_back(ToPoint(point));
  message.colors.reserve(marker.colours.size());
  for (const robot::Colour& colour : marker.colours)
    message.colors.push_back(ToColour(colour));
  return message;
}

visualization_msgs::MarkerArray ToMarkers(const std::vector<robot::Marker>& markers,
                                          const FrameNames& frames) {
  visualization_msgs::MarkerArray array;
  for (const robot::Marker& marker : markers)
    array.markers.push_back(ToMarker(marker, frames));
  return array;
}

sensor_msgs::PointCloud2 ToPoints(std_msgs::Header header, const api::Mesh& mesh) {
  constexpr std::uint32_t kFloat = 4;
  robot::PointRows rows = robot::ToPointRows(mesh);
  sensor_msgs::PointCloud2 cloud;
  cloud.header = std::move(header);
  cloud.height = 1;
  cloud.width = rows.num_points;
  cloud.fields = {Field("x", 0), Field("y", kFloat), Field("z", 2 * kFloat)};
  if (rows.has_colours) cloud.fields.push_back(Field("rgb", 3 * kFloat));
  cloud.point_step = rows.bytes_per_point;
  cloud.row_step = cloud.point_step * cloud.width;
  cloud.is_dense = true;
  cloud.data = std::move(rows.bytes);
  return cloud;
}

diagnostic_msgs::DiagnosticStatus ToStatus(const robot::Diagnosis& diagnosis,
                                           const std::string& node) {
  diagnostic_msgs::DiagnosticStatus status;
  status.level = static_cast<std::int8_t>(diagnosis.level);
  status.name = node + ": odometry";
  status.hardware_id = "facet";
  status.message = diagnosis.summary;
  for (const auto& [key, value] : diagnosis.values) {
    diagnostic_msgs::KeyValue pair;
    pair.key = key;
    pair.value = value;
    status.values.push_back(pair);
  }
  return status;
}

}  // namespace ros1
}  // namespace facet
