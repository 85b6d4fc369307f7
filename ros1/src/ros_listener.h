// SPDX-License-Identifier: BSD-2-Clause
// Publishes what the node tells.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <ros/node_handle.h>
#include <ros/publisher.h>

#include "facet/robot/node_parameters.h"
#include "facet/robot/robot_output.h"

namespace facet {
namespace ros1 {

/// roscpp's publishers are thread-safe, and drop the oldest where a subscriber is too slow.
class RosListener : public robot::RobotListener {
 public:
  /// `on_map_subscriber` is called when somebody begins to listen to the map.
  RosListener(ros::NodeHandle& global,
              ros::NodeHandle& own,
              const robot::NodeParameters& parameters,
              std::function<void()> on_map_subscriber);

  void OnOdometry(const robot::OdometryOutput& odometry) override;
  void OnPose(const robot::PoseOutput& pose) override;
  void OnPath(const std::vector<robot::PathPose>& path) override;
  void OnMapTransform(const api::Pose& T_map_odom) override;
  void OnMesh(const api::Mesh& horizon) override;
  void OnMap(std::int64_t t_ns, const std::vector<robot::MapPartOutput>& parts) override;
  void OnPlanes(const robot::PlanesOutput& planes) override;
  void OnClear() override;
  void OnLog(robot::LogLevel level, const std::string& text) override;
  bool WantsOdometry() const override;
  bool WantsMesh() const override;
  bool WantsScene() const override;

  void Publish(const robot::Diagnosis& diagnosis);

 private:
  const robot::FrameNames frames_;
  const bool publishes_tf_, publishes_map_tf_;
  ros::Publisher odometry_, pose_, path_, mesh_, points_, map_, planes_;
  ros::Publisher tf_, tf_static_, diagnostics_;
};

}  // namespace ros1
}  // namespace facet
