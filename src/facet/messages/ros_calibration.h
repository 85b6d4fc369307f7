// SPDX-License-Identifier: BSD-2-Clause
// The calibration that a bag carries: CameraInfo of both cameras and static transforms.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "facet/io/calibration_file.h"
#include "facet/messages/ros_messages.h"

namespace facet {

/// What was found in the bag.
struct RosCalibrationMessages {
  std::array<std::optional<CameraInfoMessage>, 2> cameras;  ///< left, right
  std::array<std::string, 2> camera_frames;                 ///< of the images; CameraInfo's wins
  std::array<bool, 2> are_rectified{};                      ///< by the name of their topic
  std::string imu_frame;
  std::vector<FrameTransform> transforms;
};

/// The calibration, or else what is missing or cannot be used, in `problem`. Noise densities of the
/// IMU are not in a bag: those of `imu_file` or built-in ones, with a warning.
struct RosCalibration {
  std::optional<Calibration> calibration;
  std::string problem;
};
RosCalibration CalibrationFromMessages(const RosCalibrationMessages& messages,
                                       const std::filesystem::path& imu_file);

/// T_C0C1, raw right camera to raw left one, from the R and P of a pair that was calibrated for
/// rectification. Empty where they say nothing, which is so where the right P has no baseline.
std::optional<SE3> RightToLeft(const std::array<CameraInfoMessage, 2>& cameras);

/// Model and coefficients of the lens, in the names that ROS has, or else Kalibr's.
void SetLens(const CameraIntrinsics& intrinsics, CameraInfoMessage& info);

/// T_ab of two frames of a tree of transforms, empty if they are not connected.
std::optional<SE3> FindTransform(const std::vector<FrameTransform>& transforms,
                                 const std::string& a,
                                 const std::string& b);

}  // namespace facet
