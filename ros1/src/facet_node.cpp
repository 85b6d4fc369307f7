// SPDX-License-Identifier: BSD-2-Clause
// Facet as a node of ROS 1: converts messages, and leaves the rest to RobotNode.
//
//   left/image_raw, right/image_raw (or .../compressed), imu, left/camera_info, right/camera_info
//     -> ~odometry, ~pose, ~path, ~mesh, ~points, ~map, ~planes, /tf, /tf_static, /diagnostics
#include <cstdio>
#include <exception>
#include <memory>
#include <string>

#include "parameters.h"
#include "ros_listener.h"
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/Imu.h>
#include <std_srvs/Trigger.h>

#include "facet/robot/make_messages.h"
#include "facet/robot/robot_node.h"

namespace facet {
namespace ros1 {
namespace {

constexpr int kUsage = 2, kInput = 3;
constexpr double kDiagnosticsPeriod = 1;  // seconds

class Node {
 public:
  Node()
      : parameters_(ReadParameters(own_)),
        listener_(global_, own_, parameters_, [this] { RepeatMap(); }),
        robot_(std::make_unique<robot::RobotNode>(parameters_.robot, listener_)) {
    imu_nodes_.setCallbackQueue(&imu_queue_);
    image_nodes_.setCallbackQueue(&image_queue_);
    Subscribe();
    Advertise();
    imu_spinner_.start();
    image_spinner_.start();
  }

  ~Node() {
    imu_spinner_.stop();
    image_spinner_.stop();
  }

 private:
  void Subscribe() {
    const auto no_delay = ros::TransportHints().tcpNoDelay();
    const auto imu_size = static_cast<std::uint32_t>(parameters_.imu_queue);
    imu_ = imu_nodes_.subscribe<sensor_msgs::Imu>(
        "imu",
        imu_size,
        [this](const sensor_msgs::ImuConstPtr& message) {
          robot_->AddImu(robot::ToSample(*message));
        },
        ros::VoidConstPtr(),
        no_delay);
    for (int camera = 0; camera < 2; ++camera)
      SubscribeCamera(camera, camera == 0 ? "left" : "right", no_delay);
  }

  void SubscribeCamera(int camera, const std::string& side, const ros::TransportHints& hints) {
    if (parameters_.has_compressed_images) {
      SubscribeImages<sensor_msgs::CompressedImage>(
          camera,
          side + "/image_raw/compressed",
          [](const auto& message) { return robot::ToCompressedImage(message); },
          hints);
    } else {
      SubscribeImages<sensor_msgs::Image>(
          camera,
          side + "/image_raw",
          [](const auto& message) { return robot::ToRawImage(message); },
          hints);
    }
    infos_[camera] = image_nodes_.subscribe<sensor_msgs::CameraInfo>(
        side + "/camera_info", 10, [this, camera](const sensor_msgs::CameraInfoConstPtr& message) {
          robot_->AddCameraInfo(camera, robot::ToCameraInfo(*message));
        });
  }

  template <class Message, class Convert>
  void SubscribeImages(int camera,
                       const std::string& topic,
                       Convert convert,
                       const ros::TransportHints& hints) {
    images_[camera] = image_nodes_.subscribe<Message>(
        topic,
        static_cast<std::uint32_t>(parameters_.image_queue),
        [this, camera, convert](const boost::shared_ptr<const Message>& message) {
          robot_->AddImage(camera, convert(message));
        },
        ros::VoidConstPtr(),
        hints);
  }

  void Advertise() {
    using Answer = robot::RobotNode::Answer;
    const auto advertise = [this](const char* name, Answer (robot::RobotNode::*act)()) {
      return own_.advertiseService<std_srvs::TriggerRequest, std_srvs::TriggerResponse>(
          name, [this, act](std_srvs::TriggerRequest&, std_srvs::TriggerResponse& response) {
            const Answer answer = (robot_.get()->*act)();
            response.success = answer.is_done;
            response.message = answer.text;
            return true;
          });
    };
    services_[0] = advertise("start", &robot::RobotNode::Start);
    services_[1] = advertise("stop", &robot::RobotNode::Stop);
    services_[2] = advertise("reset", &robot::RobotNode::Reset);
    // By the machine's clock: it must go on where the simulated one stands still.
    timer_ = own_.createWallTimer(
        ros::WallDuration(kDiagnosticsPeriod),
        [this](const ros::WallTimerEvent&) { listener_.Publish(robot_->Diagnose()); });
  }

  void RepeatMap() {
    if (robot_) robot_->RepeatMap();
  }

  ros::NodeHandle global_, own_{"~"};
  const robot::NodeParameters parameters_;
  RosListener listener_;
  std::unique_ptr<robot::RobotNode> robot_;
  // Decoding images must not hold up the IMU, so each has a queue and a thread.
  ros::NodeHandle imu_nodes_, image_nodes_;
  ros::CallbackQueue imu_queue_, image_queue_;
  ros::Subscriber imu_, images_[2], infos_[2];
  ros::ServiceServer services_[3];
  ros::WallTimer timer_;
  ros::AsyncSpinner imu_spinner_{1, &imu_queue_}, image_spinner_{1, &image_queue_};
};

// With the node its handles are gone, and with the last of them ROS's own log.
int Complain(const std::exception& error, int exit_code) {
  std::fprintf(stderr, "facet_node: %s\n", error.what());
  return exit_code;
}

int Run() {
  try {
    const Node node;
    ros::spin();
    return 0;
  } catch (const robot::CalibrationError& error) {
    return Complain(error, kInput);
  } catch (const api::Error& error) {
    return Complain(error, kUsage);
  } catch (const std::exception& error) {
    return Complain(error, 1);
  }
}

}  // namespace
}  // namespace ros1
}  // namespace facet

int main(int argc, char** argv) {
  ros::init(argc, argv, "facet");
  facet::api::ForbidOpenCvThreads();
  return facet::ros1::Run();
}
