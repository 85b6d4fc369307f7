// SPDX-License-Identifier: BSD-2-Clause
#include "ros_listener.h"

#include <utility>

#include <ros/console.h>
#include <ros/this_node.h>
#include <tf2_msgs/TFMessage.h>

namespace facet {
namespace ros1 {

namespace {

// Two seconds of the IMU; ten of poses; a whole map in parts.
constexpr std::uint32_t kOdometryQueue = 400, kPoseQueue = 200, kSceneQueue = 10, kMapQueue = 5000;

}  // namespace

RosListener::RosListener(ros::NodeHandle& global,
                         ros::NodeHandle& own,
                         const robot::NodeParameters& parameters,
                         std::function<void()> on_map_subscriber)
    : frames_(parameters.frames), publishes_tf_(parameters.publishes_tf) {
  odometry_ = own.advertise<nav_msgs::Odometry>("odometry", kOdometryQueue);
  pose_ = own.advertise<geometry_msgs::PoseWithCovarianceStamped>("pose", kPoseQueue);
  path_ = own.advertise<nav_msgs::Path>("path", kSceneQueue, true);
  mesh_ = own.advertise<visualization_msgs::Marker>("mesh", kSceneQueue);
  points_ = own.advertise<sensor_msgs::PointCloud2>("points", kSceneQueue);
  map_ = own.advertise<visualization_msgs::Marker>(
      "map",
      kMapQueue,
      [on_map_subscriber = std::move(on_map_subscriber)](const ros::SingleSubscriberPublisher&) {
        on_map_subscriber();
      });
  planes_ = own.advertise<visualization_msgs::MarkerArray>("planes", kSceneQueue, true);
  diagnostics_ = global.advertise<diagnostic_msgs::DiagnosticArray>("/diagnostics", kSceneQueue);
  if (publishes_tf_) tf_ = global.advertise<tf2_msgs::TFMessage>("/tf", kOdometryQueue);
  if (parameters.publishes_map_tf) PublishMapTransform();
}

// Nothing corrects the drift of the odometry yet.
void RosListener::PublishMapTransform() {
  tf_static_ = ros::NodeHandle().advertise<tf2_msgs::TFMessage>("/tf_static", 1, true);
  tf2_msgs::TFMessage message;
  message.transforms = {ToTransform(Header(0, frames_.map), frames_.odom, api::Pose())};
  tf_static_.publish(message);
}

void RosListener::OnOdometry(const robot::OdometryOutput& odometry) {
  const nav_msgs::Odometry message = ToOdometry(odometry, frames_);
  odometry_.publish(message);
  if (!publishes_tf_) return;
  tf2_msgs::TFMessage transforms;
  transforms.transforms = {ToTransform(message.header, frames_.base, odometry.T_odom_base)};
  tf_.publish(transforms);
}

void RosListener::OnPose(const robot::PoseOutput& pose) {
  pose_.publish(ToPose(pose, frames_));
}

void RosListener::OnPath(const std::vector<robot::PathPose>& path) {
  path_.publish(ToPath(path, frames_));
}

void RosListener::OnMesh(const api::Mesh& horizon) {
  const std_msgs::Header header = Header(horizon.t_ns, frames_.odom);
  if (mesh_.getNumSubscribers() > 0)
    mesh_.publish(ToMarker(robot::MeshMarker(horizon.t_ns, "horizon", 0, horizon), frames_));
  if (points_.getNumSubscribers() > 0) points_.publish(ToPoints(header, horizon));
}

void RosListener::OnMap(std::int64_t t_ns, const std::vector<robot::MapPartOutput>& parts) {
  for (const robot::MapPartOutput& part : parts)
    map_.publish(ToMarker(robot::MeshMarker(t_ns, "map", part.id, part.mesh), frames_));
}

void RosListener::OnPlanes(const robot::PlanesOutput& planes) {
  planes_.publish(ToMarkers(robot::PlaneMarkers(planes), frames_));
}

void RosListener::OnClear() {
  const visualization_msgs::Marker removal = ToMarker(robot::RemovalOfAll(), frames_);
  mesh_.publish(removal);
  map_.publish(removal);
  visualization_msgs::MarkerArray removals;
  removals.markers = {removal};
  planes_.publish(removals);
  path_.publish(ToPath({}, frames_));
}

void RosListener::OnLog(robot::LogLevel level, const std::string& text) {
  switch (level) {
    case robot::LogLevel::kInfo:
      ROS_INFO_STREAM(text);
      break;
    case robot::LogLevel::kWarning:
      ROS_WARN_STREAM(text);
      break;
    case robot::LogLevel::kError:
      ROS_ERROR_STREAM(text);
      break;
  }
}

bool RosListener::WantsOdometry() const {
  return odometry_.getNumSubscribers() > 0 || (publishes_tf_ && tf_.getNumSubscribers() > 0);
}

bool RosListener::WantsMesh() const {
  return mesh_.getNumSubscribers() + points_.getNumSubscribers() > 0;
}

bool RosListener::WantsScene() const {
  return map_.getNumSubscribers() + planes_.getNumSubscribers() > 0;
}

void RosListener::Publish(const robot::Diagnosis& diagnosis) {
  diagnostic_msgs::DiagnosticArray message;
  message.header.stamp = ros::Time::now();
  message.status = {ToStatus(diagnosis, ros::this_node::getName())};
  diagnostics_.publish(message);
}

}  // namespace ros1
}  // namespace facet
