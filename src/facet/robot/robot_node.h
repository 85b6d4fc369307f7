// SPDX-License-Identifier: BSD-2-Clause
// Facet on a robot, without its middleware: what a node does with the messages that come, and what
// it publishes when. A node of ROS or DDS converts messages and calls this, and nothing else.
//
//   images, IMU, CameraInfo -> RobotNode -> api::LiveOdometry
//   odometry, path, mesh, map, planes, log -> RobotListener
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "facet/facet.h"
#include "facet/robot/image_pairer.h"
#include "facet/robot/robot_options.h"
#include "facet/robot/robot_output.h"

namespace facet {
namespace robot {

/// Thread-safe: IMU, images and services may come from threads of their own, each sensor in order
/// of time. Where the clock of the sensors goes back by more than a second, as when a bag is played
/// again, everything begins anew.
class RobotNode {
 public:
  /// Throws api::Error where the options are wrong. The listener must outlive the node.
  RobotNode(const RobotOptions& options, RobotListener& listener);
  /// Drops what waits.
  ~RobotNode();
  RobotNode(const RobotNode&) = delete;
  RobotNode& operator=(const RobotNode&) = delete;

  /// Returns at once, with the odometry at its stamp told to the listener.
  void AddImu(const api::ImuSample& sample);

  /// `camera`: 0 left, 1 right. Decodes with the second image of a pair, which takes as long as
  /// that takes: from a thread that may wait. `image.owner` keeps the bytes alive.
  void AddImage(int camera, const ReceivedImage& image);

  /// Used where the options have no calibration, until there is one.
  void AddCameraInfo(int camera, const api::CameraInfo& info);

  struct Answer {
    bool is_done = false;
    std::string text;  ///< what has been done, or why not
  };
  Answer Start();
  /// Data are not looked at until Start, which begins anew.
  Answer Stop();
  Answer Reset();

  /// Tells the listener of the whole map once more, for whoever begins to listen.
  void RepeatMap();

  /// How it goes, once a second or so: counts what has been lost since the last time.
  Diagnosis Diagnose();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace robot
}  // namespace facet
