// SPDX-License-Identifier: BSD-2-Clause
#include "ros_listener.h"

#include <utility>

#include <diagnostic_msgs/DiagnosticArray.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <nav_msgs/Odometry.h>
#include <nav_msgs/Path.h>
#include <ros/console.h>
#include <ros/this_node.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2_msgs/TFMessage.h>
#include <visualization_msgs/MarkerArray.h>

#include "facet/robot/make_messages.h"

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
    : frames_(parameters.frames),
      publishes_tf_(parameters.publishes_tf),
      publishes_map_tf_(parameters.publishes_map_tf) {
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
  if (publishes_map_tf_) tf_static_ = global.advertise<tf2_msgs::TFMessage>("/tf_static", 1, true);
}

// Latched, and anew when it changes: a correction is about all of odom, whatever the time.
void RosListener::OnMapTransform(const api::Pose& T_map_odom) {
  if (publishes_map_tf_)
    tf_static_.publish(
        robot::ToTransforms<tf2_msgs::TFMessage>(0, frames_.map, frames_.odom, T_map_odom));
}

void RosListener::OnOdometry(const robot::OdometryOutput& odometry) {
  odometry_.publish(robot::ToOdometry<nav_msgs::Odometry>(odometry, frames_));
  if (publishes_tf_)
    tf_.publish(robot::ToTransforms<tf2_msgs::TFMessage>(
        odometry.t_ns, frames_.odom, frames_.base, odometry.T_odom_base));
}

void RosListener::OnPose(const robot::PoseOutput& pose) {
  pose_.publish(robot::ToPose<geometry_msgs::PoseWithCovarianceStamped>(pose, frames_));
}

void RosListener::OnPath(const std::vector<robot::PathPose>& path) {
  path_.publish(robot::ToPath<nav_msgs::Path>(path, frames_));
}

void RosListener::OnMesh(const api::Mesh& horizon) {
  if (mesh_.getNumSubscribers() > 0)
    mesh_.publish(robot::ToMarker<visualization_msgs::Marker>(
        robot::MeshMarker(horizon.t_ns, "horizon", 0, horizon), frames_));
  if (points_.getNumSubscribers() > 0)
    points_.publish(robot::ToPoints<sensor_msgs::PointCloud2>(horizon, frames_));
}

void RosListener::OnMap(std::int64_t t_ns, const std::vector<robot::MapPartOutput>& parts) {
  for (const robot::MapPartOutput& part : parts)
    map_.publish(robot::ToMarker<visualization_msgs::Marker>(
        robot::MeshMarker(t_ns, "map", part.id, part.mesh), frames_));
}

void RosListener::OnPlanes(const robot::PlanesOutput& planes) {
  planes_.publish(
      robot::ToMarkers<visualization_msgs::MarkerArray>(robot::PlaneMarkers(planes), frames_));
}

void RosListener::OnClear() {
  const auto removals =
      robot::ToMarkers<visualization_msgs::MarkerArray>({robot::RemovalOfAll()}, frames_);
  mesh_.publish(removals.markers.front());
  map_.publish(removals.markers.front());
  planes_.publish(removals);
  OnPath({});
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
  auto message =
      robot::ToDiagnostics<diagnostic_msgs::DiagnosticArray>(diagnosis, ros::this_node::getName());
  message.header.stamp = ros::Time::now();
  diagnostics_.publish(message);
}

}  // namespace ros1
}  // namespace facet
