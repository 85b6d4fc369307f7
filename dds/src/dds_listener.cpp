// SPDX-License-Identifier: BSD-2-Clause
#include "dds_listener.h"

#include <chrono>
#include <cstdio>

namespace facet::dds {

namespace {

// Two seconds of the IMU; ten of poses; a whole map in parts. Mesh and map have a thread that may
// wait, but also hold up a restart while they do.
constexpr Quality kOdometry{true, false, 400, 0}, kPose{true, false, 200, 0};
constexpr Quality kScene{true, false, 10, 50}, kMap{true, false, 5000, 50};
constexpr Quality kLatched{true, true, 1, 0}, kDiagnostics{true, false, 10, 0};

std::int64_t MachineTime_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace

DdsListener::DdsListener(const Entity& participant,
                         const NodeNames& names,
                         const robot::NodeParameters& parameters)
    : name_(names.Resolve("~")),
      frames_(parameters.frames),
      odometry_(
          participant, nav_msgs_msg_dds__Odometry__desc, names.Topic("~/odometry"), kOdometry),
      pose_(participant,
            geometry_msgs_msg_dds__PoseWithCovarianceStamped__desc,
            names.Topic("~/pose"),
            kPose),
      path_(participant, nav_msgs_msg_dds__Path__desc, names.Topic("~/path"), kLatched),
      mesh_(participant, visualization_msgs_msg_dds__Marker__desc, names.Topic("~/mesh"), kScene),
      points_(participant, sensor_msgs_msg_dds__PointCloud2__desc, names.Topic("~/points"), kScene),
      map_(participant, visualization_msgs_msg_dds__Marker__desc, names.Topic("~/map"), kMap),
      planes_(participant,
              visualization_msgs_msg_dds__MarkerArray__desc,
              names.Topic("~/planes"),
              kLatched),
      diagnostics_(participant,
                   diagnostic_msgs_msg_dds__DiagnosticArray__desc,
                   names.Topic("/diagnostics"),
                   kDiagnostics) {
  if (parameters.publishes_tf)
    tf_.emplace(participant, tf2_msgs_msg_dds__TFMessage__desc, names.Topic("/tf"), kOdometry);
  if (parameters.publishes_map_tf)
    tf_static_.emplace(
        participant, tf2_msgs_msg_dds__TFMessage__desc, names.Topic("/tf_static"), kLatched);
}

// Latched, and anew when it changes: a correction is about all of odom, whatever the time.
void DdsListener::OnMapTransform(const api::Pose& T_map_odom) {
  if (!tf_static_) return;
  TransformStamped transform = ToTransform(0, frames_.map, frames_.odom, T_map_odom);
  Write(*tf_static_, ToTransforms(transform));
}

template <class Message>
bool DdsListener::Write(const Writer<Message>& writer, const Message& message) {
  const bool is_written = writer.Write(message);
  if (!is_written) ++num_dropped_;
  return is_written;
}

void DdsListener::OnOdometry(const robot::OdometryOutput& odometry) {
  Write(odometry_, ToOdometry(odometry, frames_));
  if (!tf_) return;
  TransformStamped transform =
      ToTransform(odometry.t_ns, frames_.odom, frames_.base, odometry.T_odom_base);
  Write(*tf_, ToTransforms(transform));
}

void DdsListener::OnPose(const robot::PoseOutput& pose) {
  Write(pose_, ToPose(pose, frames_));
}

void DdsListener::OnPath(const std::vector<robot::PathPose>& path) {
  Write(path_, PathMessage(path, frames_).message);
}

void DdsListener::OnMesh(const api::Mesh& horizon) {
  if (mesh_.HasReader()) {
    const robot::Marker marker = robot::MeshMarker(horizon.t_ns, "horizon", 0, horizon);
    Write(mesh_, MarkerMessage(marker, frames_).message);
  }
  if (points_.HasReader()) Write(points_, PointsMessage(horizon, frames_).message);
}

void DdsListener::OnMap(std::int64_t t_ns, const std::vector<robot::MapPartOutput>& parts) {
  for (const robot::MapPartOutput& part : parts) {
    const robot::Marker marker = robot::MeshMarker(t_ns, "map", part.id, part.mesh);
    // Who does not take one part does not take the others; all of them are told again later.
    if (Write(map_, MarkerMessage(marker, frames_).message)) continue;
    lacks_map_ = true;
    return;
  }
}

void DdsListener::OnPlanes(const robot::PlanesOutput& planes) {
  const std::vector<robot::Marker> markers = robot::PlaneMarkers(planes);
  Write(planes_, MarkersMessage(markers, frames_).message);
}

void DdsListener::OnClear() {
  const std::vector<robot::Marker> removal = {robot::RemovalOfAll()};
  const MarkersMessage removals(removal, frames_);
  Write(mesh_, removals.markers.front());
  if (!Write(map_, removals.markers.front())) lacks_map_ = true;
  Write(planes_, removals.message);
  OnPath({});
}

void DdsListener::OnLog(robot::LogLevel level, const std::string& text) {
  const char* const kNames[] = {"INFO", "WARN", "ERROR"};
  std::fprintf(
      stderr, "[%s] [%s]: %s\n", kNames[static_cast<int>(level)], name_.c_str(), text.c_str());
}

bool DdsListener::WantsOdometry() const {
  return odometry_.HasReader() || (tf_ && tf_->HasReader());
}

bool DdsListener::WantsMesh() const {
  return mesh_.HasReader() || points_.HasReader();
}

bool DdsListener::WantsScene() const {
  return map_.HasReader() || planes_.HasReader();
}

void DdsListener::Publish(robot::Diagnosis diagnosis) {
  diagnosis.values.emplace_back("dropped messages", std::to_string(num_dropped_.load()));
  Write(diagnostics_, DiagnosticMessage(diagnosis, name_, MachineTime_ns()).message);
}

}  // namespace facet::dds
