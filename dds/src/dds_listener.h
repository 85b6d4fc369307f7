// SPDX-License-Identifier: BSD-2-Clause
// Publishes what the node tells.
#pragma once

#include <atomic>
#include <optional>
#include <string>
#include <vector>

#include "arguments.h"
#include "entities.h"
#include "messages.h"

#include "facet/robot/robot_output.h"

namespace facet::dds {

/// A sample that a reliable reader does not take in time is dropped and counted.
class DdsListener : public robot::RobotListener {
 public:
  DdsListener(const Entity& participant,
              const NodeNames& names,
              const robot::NodeParameters& parameters);

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

  /// With the number of samples that were dropped so far.
  void Publish(robot::Diagnosis diagnosis);
  dds_entity_t map_writer() const { return map_.handle(); }
  /// Whether a part of the map was dropped since the last call: the map has to be told once more.
  bool TakeLackOfMap() { return lacks_map_.exchange(false); }

 private:
  template <class Message>
  bool Write(const Writer<Message>& writer, const Message& message);

  const std::string name_;
  const robot::FrameNames frames_;
  std::atomic<std::int64_t> num_dropped_{0};
  std::atomic<bool> lacks_map_{false};
  Writer<Odometry> odometry_;
  Writer<PoseWithCovarianceStamped> pose_;
  Writer<Path> path_;
  Writer<Marker> mesh_;
  Writer<PointCloud2> points_;
  Writer<Marker> map_;
  Writer<MarkerArray> planes_;
  Writer<DiagnosticArray> diagnostics_;
  std::optional<Writer<TFMessage>> tf_, tf_static_;
};

}  // namespace facet::dds
