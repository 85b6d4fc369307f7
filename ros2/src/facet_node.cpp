// SPDX-License-Identifier: BSD-2-Clause
// Facet as a node of ROS 2 on rclcpp: converts messages, and leaves the rest to RobotNode. Not
// compiled where Facet is made, for want of rclcpp; facet-dds (dds/src/facet_dds.cpp) is the same
// node without ROS, and is tested.
#include <chrono>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "parameters.h"
#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <geometry_msgs/msg/pose_with_covariance_stamped.hpp>
#include <nav_msgs/msg/odometry.hpp>
#include <nav_msgs/msg/path.hpp>
#include <rclcpp/rclcpp.hpp>
#include <sensor_msgs/msg/camera_info.hpp>
#include <sensor_msgs/msg/compressed_image.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <sensor_msgs/msg/imu.hpp>
#include <sensor_msgs/msg/point_cloud2.hpp>
#include <std_srvs/srv/trigger.hpp>
#include <tf2_msgs/msg/tf_message.hpp>
#include <visualization_msgs/msg/marker_array.hpp>

#include "facet/robot/make_messages.h"
#include "facet/robot/robot_node.h"

namespace facet::ros2 {
namespace {

using diagnostic_msgs::msg::DiagnosticArray;
using geometry_msgs::msg::PoseWithCovarianceStamped;
using nav_msgs::msg::Odometry;
using nav_msgs::msg::Path;
using sensor_msgs::msg::PointCloud2;
using std_srvs::srv::Trigger;
using tf2_msgs::msg::TFMessage;
using visualization_msgs::msg::Marker;
using visualization_msgs::msg::MarkerArray;

class Node : public rclcpp::Node, public robot::RobotListener {
 public:
  Node()
      : rclcpp::Node("facet",
                     rclcpp::NodeOptions().automatically_declare_parameters_from_overrides(true)) {
    Parameters(*this).Get("reliable", is_reliable_);
    robot_ = std::make_unique<robot::RobotNode>(parameters_.robot, *this);
    Listen<sensor_msgs::msg::Imu>(
        "imu", parameters_.imu_queue, imu_group_, [this](const auto& message) {
          robot_->AddImu(robot::ToSample(*message));
        });
    SubscribeCamera(0, "left");
    SubscribeCamera(1, "right");
    Serve("~/start", &robot::RobotNode::Start);
    Serve("~/stop", &robot::RobotNode::Stop);
    Serve("~/reset", &robot::RobotNode::Reset);
    timer_ = create_wall_timer(std::chrono::seconds(1), [this] { EverySecond(); });
  }

  void OnOdometry(const robot::OdometryOutput& odometry) override {
    odometry_->publish(robot::ToOdometry<Odometry>(odometry, frames_));
    if (parameters_.publishes_tf)
      tf_->publish(robot::ToTransforms<TFMessage>(
          odometry.t_ns, frames_.odom, frames_.base, odometry.T_odom_base));
  }
  void OnPose(const robot::PoseOutput& pose) override {
    pose_->publish(robot::ToPose<PoseWithCovarianceStamped>(pose, frames_));
  }
  void OnMapTransform(const api::Pose& T_map_odom) override {
    if (parameters_.publishes_map_tf)
      tf_static_->publish(robot::ToTransforms<TFMessage>(0, frames_.map, frames_.odom, T_map_odom));
  }
  void OnPath(const std::vector<robot::PathPose>& path) override {
    path_->publish(robot::ToPath<Path>(path, frames_));
  }
  void OnMesh(const api::Mesh& horizon) override {
    mesh_->publish(
        robot::ToMarker<Marker>(robot::MeshMarker(horizon.t_ns, "horizon", 0, horizon), frames_));
    points_->publish(robot::ToPoints<PointCloud2>(horizon, frames_));
  }
  void OnMap(std::int64_t t_ns, const std::vector<robot::MapPartOutput>& parts) override {
    for (const robot::MapPartOutput& part : parts)
      map_->publish(
          robot::ToMarker<Marker>(robot::MeshMarker(t_ns, "map", part.id, part.mesh), frames_));
  }
  void OnPlanes(const robot::PlanesOutput& planes) override {
    planes_->publish(robot::ToMarkers<MarkerArray>(robot::PlaneMarkers(planes), frames_));
  }
  void OnClear() override {
    const auto removals = robot::ToMarkers<MarkerArray>({robot::RemovalOfAll()}, frames_);
    mesh_->publish(removals.markers.front());
    map_->publish(removals.markers.front());
    planes_->publish(removals);
    OnPath({});
  }
  void OnLog(robot::LogLevel level, const std::string& text) override {
    if (level == robot::LogLevel::kInfo) RCLCPP_INFO(get_logger(), "%s", text.c_str());
    if (level == robot::LogLevel::kWarning) RCLCPP_WARN(get_logger(), "%s", text.c_str());
    if (level == robot::LogLevel::kError) RCLCPP_ERROR(get_logger(), "%s", text.c_str());
  }
  bool WantsOdometry() const override {
    return odometry_->get_subscription_count() > 0 ||
           (parameters_.publishes_tf && tf_->get_subscription_count() > 0);
  }
  bool WantsMesh() const override {
    return mesh_->get_subscription_count() + points_->get_subscription_count() > 0;
  }
  bool WantsScene() const override {
    return map_->get_subscription_count() + planes_->get_subscription_count() > 0;
  }

 private:
  template <class Message>
  typename rclcpp::Publisher<Message>::SharedPtr Advertise(const std::string& name,
                                                           std::size_t depth,
                                                           bool is_latched = false) {
    rclcpp::QoS qos(depth);
    if (is_latched) qos.transient_local();
    return create_publisher<Message>(name, qos);
  }

  template <class Message, class Use>
  void Listen(const std::string& name,
              int queue,
              const rclcpp::CallbackGroup::SharedPtr& group,
              Use use) {
    rclcpp::QoS qos(static_cast<std::size_t>(queue));
    if (!is_reliable_) qos.best_effort();
    rclcpp::SubscriptionOptions options;
    options.callback_group = group;
    subscriptions_.push_back(create_subscription<Message>(
        name, qos, [use](std::shared_ptr<const Message> message) { use(message); }, options));
  }

  void SubscribeCamera(int camera, const std::string& side) {
    const int queue = parameters_.image_queue;
    Listen<sensor_msgs::msg::CameraInfo>(
        side + "/camera_info", 10, image_group_, [this, camera](const auto& message) {
          robot_->AddCameraInfo(camera, robot::ToCameraInfo(*message));
        });
    if (parameters_.has_compressed_images) {
      const std::string topic = side + "/image_raw/compressed";
      Listen<sensor_msgs::msg::CompressedImage>(
          topic, queue, image_group_, [this, camera](const auto& message) {
            robot_->AddImage(camera, robot::ToCompressedImage(message));
          });
    } else {
      Listen<sensor_msgs::msg::Image>(
          side + "/image_raw", queue, image_group_, [this, camera](const auto& message) {
            robot_->AddImage(camera, robot::ToRawImage(message));
          });
    }
  }

  void Serve(const std::string& name, robot::RobotNode::Answer (robot::RobotNode::*act)()) {
    services_.push_back(create_service<Trigger>(
        name,
        [this, act](const Trigger::Request::SharedPtr, Trigger::Response::SharedPtr response) {
          const robot::RobotNode::Answer answer = (robot_.get()->*act)();
          response->success = answer.is_done;
          response->message = answer.text;
        }));
  }

  void EverySecond() {
    auto message =
        robot::ToDiagnostics<DiagnosticArray>(robot_->Diagnose(), get_fully_qualified_name());
    message.header.stamp = rclcpp::Clock(RCL_SYSTEM_TIME).now();
    diagnostics_->publish(message);
    const std::size_t num = map_->get_subscription_count();
    if (num > num_map_readers_) robot_->RepeatMap();
    num_map_readers_ = num;
  }

  const robot::NodeParameters parameters_ = robot::ReadParameters(Parameters(*this));
  const robot::FrameNames frames_ = parameters_.frames;
  bool is_reliable_ = false;
  std::size_t num_map_readers_ = 0;
  // Decoding images must not hold up the IMU, so each has a group, which the executor gives a
  // thread.
  rclcpp::CallbackGroup::SharedPtr imu_group_ =
      create_callback_group(rclcpp::CallbackGroupType::MutuallyExclusive);
  rclcpp::CallbackGroup::SharedPtr image_group_ =
      create_callback_group(rclcpp::CallbackGroupType::MutuallyExclusive);
  rclcpp::Publisher<Odometry>::SharedPtr odometry_ = Advertise<Odometry>("~/odometry", 400);
  rclcpp::Publisher<PoseWithCovarianceStamped>::SharedPtr pose_ =
      Advertise<PoseWithCovarianceStamped>("~/pose", 200);
  rclcpp::Publisher<Path>::SharedPtr path_ = Advertise<Path>("~/path", 1, true);
  rclcpp::Publisher<Marker>::SharedPtr mesh_ = Advertise<Marker>("~/mesh", 10),
                                       map_ = Advertise<Marker>("~/map", 5000);
  rclcpp::Publisher<PointCloud2>::SharedPtr points_ = Advertise<PointCloud2>("~/points", 10);
  rclcpp::Publisher<MarkerArray>::SharedPtr planes_ = Advertise<MarkerArray>("~/planes", 1, true);
  rclcpp::Publisher<TFMessage>::SharedPtr tf_ = Advertise<TFMessage>("/tf", 400),
                                          tf_static_ = Advertise<TFMessage>("/tf_static", 1, true);
  rclcpp::Publisher<DiagnosticArray>::SharedPtr diagnostics_ =
      Advertise<DiagnosticArray>("/diagnostics", 10);
  std::vector<rclcpp::SubscriptionBase::SharedPtr> subscriptions_;
  std::vector<rclcpp::ServiceBase::SharedPtr> services_;
  rclcpp::TimerBase::SharedPtr timer_;
  std::unique_ptr<robot::RobotNode> robot_;  // ends before what it publishes to
};

int Run() {
  try {
    const auto node = std::make_shared<Node>();
    rclcpp::executors::MultiThreadedExecutor executor(rclcpp::ExecutorOptions(), 3);
    executor.add_node(node);
    executor.spin();
    return 0;
  } catch (const robot::CalibrationError& error) {
    std::fprintf(stderr, "facet_node: %s\n", error.what());
    return 3;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "facet_node: %s\n", error.what());
    return 2;
  }
}

}  // namespace
}  // namespace facet::ros2

int main(int argc, char** argv) {
  rclcpp::init(argc, argv);
  facet::api::ForbidOpenCvThreads();
  const int exit_code = facet::ros2::Run();
  rclcpp::shutdown();
  return exit_code;
}
