// SPDX-License-Identifier: BSD-2-Clause
// With stand-ins for messages of ROS 2, which have the fields of those of common_interfaces.
// ros1/test/messages_test.cpp has the messages of ROS 1.
#include "facet/robot/make_messages.h"

#include <gtest/gtest.h>

namespace facet {
namespace robot {
namespace {

struct Stamp {
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
};
struct Header {
  Stamp stamp;
  std::string frame_id;
};
struct Vector {
  double x = 0, y = 0, z = 0;
};
struct Rotation {
  double x = 0, y = 0, z = 0, w = 0;
};
struct PoseMessage {
  Vector position;
  Rotation orientation;
};
struct PoseWithCovariance {
  PoseMessage pose;
  std::array<double, 36> covariance{{}};
};
struct StampedPose {
  Header header;
  PoseWithCovariance pose;
};
struct Imu {
  Header header;
  Vector angular_velocity, linear_acceleration;
};
struct Info {
  std::uint32_t width = 0, height = 0;
  std::string distortion_model;
  std::vector<double> d;
  std::array<double, 9> k{{}}, r{{}};
  std::array<double, 12> p{{}};
};
struct RawImage {
  Header header;
  std::uint32_t width = 0, height = 0, step = 0;
  std::string encoding;
  std::uint8_t is_bigendian = 0;
  std::vector<std::uint8_t> data;
};

constexpr std::int64_t kStamp_ns = 1403636584763555584;

TEST(MakeMessagesTest, StampsOfRos2AreRead) {
  Imu imu;
  imu.header.stamp = {1403636584, 763555584};
  imu.angular_velocity = {1, 2, 3};
  imu.linear_acceleration = {4, 5, 6};
  const api::ImuSample sample = ToSample(imu);
  EXPECT_EQ(sample.t_ns, kStamp_ns);
  EXPECT_EQ(sample.gyro, (api::Vec3{{1, 2, 3}}));
  EXPECT_EQ(sample.accel, (api::Vec3{{4, 5, 6}}));
}

TEST(MakeMessagesTest, StampsOfRos2AreWritten) {
  PoseOutput output;
  output.t_ns = kStamp_ns;
  output.T_odom_base = {{{1, 2, 3}}, {{0.5, 0.5, -0.5, 0.5}}};
  output.covariance[35] = 7;
  const auto message = ToPose<StampedPose>(output, FrameNames());
  EXPECT_EQ(message.header.stamp.sec, 1403636584);
  EXPECT_EQ(message.header.stamp.nanosec, 763555584u);
  EXPECT_EQ(message.header.frame_id, "odom");
  EXPECT_EQ(message.pose.pose.position.y, 2);
  EXPECT_EQ(message.pose.pose.orientation.y, -0.5);
  EXPECT_EQ(message.pose.covariance[35], 7);
}

TEST(MakeMessagesTest, CameraInfoOfRos2HasSmallLetters) {
  Info message;
  message.width = 640;
  message.d = {1, 2, 3, 4, 5};
  message.k[4] = 7;
  message.r[8] = 8;
  message.p[11] = 9;
  const api::CameraInfo info = ToCameraInfo(message);
  EXPECT_EQ(info.width, 640);
  EXPECT_EQ(info.D.size(), 5u);
  EXPECT_EQ(info.K[4], 7);
  EXPECT_EQ(info.R[8], 8);
  EXPECT_EQ(info.P[11], 9);
}

TEST(MakeMessagesTest, AnImageIsNotCopiedAndKeepsItsMessage) {
  auto message = std::make_shared<RawImage>();
  message->encoding = "mono8";
  message->data = {1, 2, 3};
  const std::weak_ptr<RawImage> alive = message;
  const std::uint8_t* bytes = message->data.data();
  ReceivedImage image = ToRawImage(message);
  message.reset();
  EXPECT_FALSE(alive.expired());
  EXPECT_EQ(image.image.bytes, bytes);
  EXPECT_EQ(image.image.num_bytes, 3u);
  image.owner.reset();
  EXPECT_TRUE(alive.expired());
}

}  // namespace
}  // namespace robot
}  // namespace facet
