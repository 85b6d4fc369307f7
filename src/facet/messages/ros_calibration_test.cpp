// SPDX-License-Identifier: BSD-2-Clause
#include "facet/messages/ros_calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/testing/lens_examples.h"

namespace facet {
namespace {

TEST(RosCalibrationTest, EveryLensSurvivesItsMessage) {
  for (const CameraIntrinsics& lens : testing::LensExamples()) {
    CameraInfoMessage info;
    info.width = static_cast<std::uint32_t>(lens.width);
    info.height = static_cast<std::uint32_t>(lens.height);
    info.K = {lens.fx, 0, lens.cx, 0, lens.fy, lens.cy, 0, 0, 1};
    SetLens(lens, info);
    RosCalibrationMessages messages;
    messages.cameras = {info, info};
    messages.camera_frames = {"left", "right"};
    messages.imu_frame = "imu";
    messages.transforms = {{"imu", "left", SE3()},
                           {"imu", "right", SE3(Quaterniond::Identity(), Vector3d(0.1, 0, 0))}};
    const RosCalibration read = CalibrationFromMessages(messages, {});
    ASSERT_TRUE(read.calibration) << info.distortion_model << ": " << read.problem;
    const CameraIntrinsics& back = read.calibration->rig.cameras[1].intrinsics();
    EXPECT_EQ(back.distortion, lens.distortion) << info.distortion_model;
    EXPECT_EQ(back.coefficients, lens.coefficients) << info.distortion_model;
  }
}

TEST(RosCalibrationTest, LensesThatAreNotKnownAreNamed) {
  CameraInfoMessage info;
  info.width = 640, info.height = 480;
  info.K = {500, 0, 320, 0, 500, 240, 0, 0, 1};
  info.distortion_model = "division";
  info.D = {0.1};
  RosCalibrationMessages messages;
  messages.cameras = {info, info};
  messages.camera_frames = {"left", "right"};
  messages.imu_frame = "imu";
  messages.transforms = {{"imu", "left", SE3()}, {"imu", "right", SE3()}};
  EXPECT_THAT(CalibrationFromMessages(messages, {}).problem, ::testing::HasSubstr("'division'"));
}

}  // namespace
}  // namespace facet
