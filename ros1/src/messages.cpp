// SPDX-License-Identifier: BSD-2-Clause
#include "messages.h"

#include <algorithm>
#include <array>
#include <cstring>
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

std_msgs::ColorRGBA Colour(float r, float g, float b) {
  std_msgs::ColorRGBA colour;
  colour.r = r;
  colour.g = g;
  colour.b = b;
  colour.a = 1;
  return colour;
}

std_msgs::ColorRGBA Colour(const std::array<std::uint8_t, 3>& c) {
  constexpr float kFull = 255;
  return Colour(static_cast<float>(c[0]) / kFull,
                static_cast<float>(c[1]) / kFull,
                static_cast<float>(c[2]) / kFull);
}

std_msgs::ColorRGBA ColourOfPlane(std::int64_t id) {
  constexpr std::array<std::array<std::uint8_t, 3>, 6> kColours = {{{{230, 75, 50}},
                                                                    {{50, 150, 230}},
                                                                    {{75, 200, 75}},
                                                                    {{230, 180, 25}},
                                                                    {{180, 75, 200}},
                                                                    {{50, 200, 180}}}};
  return Colour(
      kColours[static_cast<std::size_t>(std::max<std::int64_t>(id, 0)) % kColours.size()]);
}

Marker EmptyMarker(std_msgs::Header header, const std::string& name, std::int32_t id) {
  Marker marker;
  marker.header = std::move(header);
  marker.ns = name;
  marker.id = id;
  marker.pose.orientation.w = 1;
  marker.frame_locked = true;
  return marker;
}

Marker Outline(const std_msgs::Header& header, const api::Plane& plane) {
  Marker marker = EmptyMarker(header, "outline", static_cast<std::int32_t>(plane.id));
  marker.type = Marker::LINE_STRIP;
  marker.scale.x = 0.02;
  marker.color = ColourOfPlane(plane.id);
  for (const api::Vec3& corner : plane.outline)
    marker.points.push_back(ToPoint(corner));
  marker.points.push_back(marker.points.front());
  return marker;
}

Marker Label(const std_msgs::Header& header, const api::Plane& plane) {
  Marker marker = EmptyMarker(header, "label", static_cast<std::int32_t>(plane.id));
  marker.type = Marker::TEXT_VIEW_FACING;
  marker.scale.z = 0.2;
  marker.color = ColourOfPlane(plane.id);
  marker.text = plane.label + " " + std::to_string(plane.id);
  const double share = 1 / static_cast<double>(plane.outline.size());
  for (const api::Vec3& corner : plane.outline) {
    marker.pose.position.x += share * corner[0];
    marker.pose.position.y += share * corner[1];
    marker.pose.position.z += share * corner[2];
  }
  return marker;
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

// A list of triangles has each corner anew for each face.
Marker ToMarker(std_msgs::Header header,
                const std::string& name,
                std::int32_t id,
                const api::Mesh& mesh) {
  Marker marker = EmptyMarker(std::move(header), name, id);
  if (mesh.faces.empty()) {
    marker.action = Marker::DELETE;
    return marker;
  }
  marker.type = Marker::TRIANGLE_LIST;
  marker.scale.x = marker.scale.y = marker.scale.z = 1;
  marker.color = Colour(0.7F, 0.7F, 0.7F);
  const bool has_colours = mesh.colours.size() == mesh.vertices.size();
  marker.points.reserve(3 * mesh.faces.size());
  if (has_colours) marker.colors.reserve(3 * mesh.faces.size());
  for (const auto& face : mesh.faces) {
    for (const int corner : face) {
      const auto i = static_cast<std::size_t>(corner);
      marker.points.push_back(ToPoint(mesh.vertices[i]));
      if (has_colours) marker.colors.push_back(Colour(mesh.colours[i]));
    }
  }
  return marker;
}

// rgb is the three bytes 0x00RRGGBB in the place of a float, as PCL and rviz read it.
sensor_msgs::PointCloud2 ToPoints(std_msgs::Header header, const api::Mesh& mesh) {
  constexpr std::uint32_t kFloat = 4;
  const bool has_colours = !mesh.vertices.empty() && mesh.colours.size() == mesh.vertices.size();
  sensor_msgs::PointCloud2 cloud;
  cloud.header = std::move(header);
  cloud.height = 1;
  cloud.width = static_cast<std::uint32_t>(mesh.vertices.size());
  cloud.fields = {Field("x", 0), Field("y", kFloat), Field("z", 2 * kFloat)};
  if (has_colours) cloud.fields.push_back(Field("rgb", 3 * kFloat));
  cloud.point_step = kFloat * static_cast<std::uint32_t>(cloud.fields.size());
  cloud.row_step = cloud.point_step * cloud.width;
  cloud.is_dense = true;
  cloud.data.resize(cloud.row_step);
  std::uint8_t* place = cloud.data.data();
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i, place += cloud.point_step) {
    std::array<float, 3> xyz{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      xyz[axis] = static_cast<float>(mesh.vertices[i][axis]);
    std::memcpy(place, xyz.data(), sizeof xyz);
    if (!has_colours) continue;
    const auto& [r, g, b] = mesh.colours[i];
    const std::uint32_t rgb = std::uint32_t{r} << 16 | std::uint32_t{g} << 8 | b;
    std::memcpy(place + sizeof xyz, &rgb, sizeof rgb);
  }
  return cloud;
}

visualization_msgs::MarkerArray ToMarkers(const robot::PlanesOutput& output,
                                          const FrameNames& frames) {
  visualization_msgs::MarkerArray array;
  const std_msgs::Header header = Header(output.t_ns, frames.odom);
  for (const api::Plane& plane : output.planes) {
    if (plane.outline.empty()) continue;
    array.markers.push_back(Outline(header, plane));
    array.markers.push_back(Label(header, plane));
  }
  for (const std::int64_t id : output.removed) {
    for (const char* name : {"outline", "label"}) {
      Marker removal = EmptyMarker(header, name, static_cast<std::int32_t>(id));
      removal.action = Marker::DELETE;
      array.markers.push_back(removal);
    }
  }
  return array;
}

Marker RemovalOfAll(const FrameNames& frames) {
  Marker marker = EmptyMarker(Header(0, frames.odom), "", 0);
  marker.action = Marker::DELETEALL;
  return marker;
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
