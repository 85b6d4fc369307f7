// SPDX-License-Identifier: BSD-2-Clause
// What is written is what the tests' own writer writes, and is read back.
#include "facet/recording/message_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/testing/recording/test_messages.h"

namespace facet {
namespace {

using ::testing::HasSubstr;

std::string AsText(const std::vector<std::uint8_t>& bytes) {
  return {bytes.begin(), bytes.end()};
}

// Frames of several lengths: alignment depends on them.
constexpr const char* kFrames[] = {"", "a", "cam", "cam_link_0"};

TEST(MessageWriterTest, Images) {
  cv::Mat wide(3, 5, CV_8UC1);
  for (int i = 0; i < 15; ++i)
    wide.at<std::uint8_t>(i / 5, i % 5) = static_cast<std::uint8_t>(65 + i);
  const cv::Mat grey = wide.colRange(0, 4);  // with gaps between the rows
  for (const char* frame : kFrames) {
    const Timestamp t{1403636580838555648};
    EXPECT_EQ(AsText(WriteImageMessage({t, frame}, grey)),
              ImageBytes(MessageEncoding::kCdr, t, frame, {4, 3, "mono8", "ABCDFGHIKLMN"}));
  }
}

TEST(MessageWriterTest, ImuSamples) {
  const ImuSample sample{Timestamp{-1}, {0.1, -0.2, 1e-300}, {9.81, -3, 0.5}};
  for (const char* frame : kFrames) {
    const auto bytes = WriteImuMessage({sample.t, frame}, sample);
    const ImuMessage read = ReadImuMessage(bytes, MessageEncoding::kCdr);
    EXPECT_EQ(read.header.t, sample.t) << "a nanosecond before 1970";
    EXPECT_EQ(read.header.frame, frame);
    EXPECT_EQ(read.sample.gyro, sample.gyro);
    EXPECT_EQ(read.sample.accel, sample.accel);
    EXPECT_EQ(bytes.size(), ImuBytes(MessageEncoding::kCdr, sample, frame).size());
  }
}

TEST(MessageWriterTest, CameraInfoAndTransforms) {
  CameraInfoMessage info;
  info.header = {Timestamp{17}, "left"};
  info.width = 752;
  info.height = 480;
  info.distortion_model = "plumb_bob";
  info.D = {1, 2, 3, 4, 5};
  info.K = {10, 0, 20, 0, 30, 40, 0, 0, 1};
  info.R = {1, 2, 3, 4, 5, 6, 7, 8, 9};
  info.P = {9, 8, 7, 6, 5, 4, 3, 2, 1, 0, -1, -2};
  EXPECT_EQ(AsText(WriteCameraInfoMessage(info)), CameraInfoBytes(MessageEncoding::kCdr, info));

  const SE3 T(Quaterniond(0.5, 0.5, -0.5, 0.5), {1, 2, 3});
  const std::vector<FrameTransform> transforms = {{"imu", "cam0", T}, {"cam0", "c1", T}};
  EXPECT_EQ(AsText(WriteTransformsMessage({}, transforms)),
            TransformsBytes(MessageEncoding::kCdr, transforms));
}

TEST(MessageWriterTest, DefinitionsHoldAllPartsThatTheyName) {
  for (const char* type : {kImageType, kImuType, kCameraInfoType, kTransformsType}) {
    const std::string text = MessageDefinition(type);
    for (const char* part : {"std_msgs/Header",
                             "builtin_interfaces/Time",
                             "geometry_msgs/Vector3",
                             "geometry_msgs/Quaternion",
                             "geometry_msgs/Transform",
                             "geometry_msgs/TransformStamped",
                             "sensor_msgs/RegionOfInterest"}) {
      const std::string name = part;
      const bool is_used =
          text.find(name + " ") != std::string::npos || text.find(name + "[") != std::string::npos;
      const bool is_defined = text.find("MSG: " + name + "\n") != std::string::npos;
      EXPECT_EQ(is_used, is_defined) << part << " in " << type;
    }
  }
}

}  // namespace
}  // namespace facet
