// SPDX-License-Identifier: BSD-2-Clause
#include "messages.h"
#include <gtest/gtest.h>

namespace facet::dds {
namespace {

TEST(DdsMessagesTest, AnImageIsNotCopiedAndKeepsItsMessage) {
  std::vector<std::uint8_t> bytes = {1, 2, 3, 4, 5, 6};
  std::string encoding = "mono8";
  auto message = std::make_shared<Image>();
  message->header.stamp = {1403636584, 763555584};
  message->encoding = encoding.data();
  message->width = message->step = 3;
  message->height = 2;
  message->data._buffer = bytes.data();
  message->data._length = 6;
  const std::weak_ptr<const Image> alive = message;
  robot::ReceivedImage image = ToImage(std::shared_ptr<const Image>(message));
  message.reset();
  EXPECT_FALSE(alive.expired());
  EXPECT_EQ(image.t_ns, 1403636584763555584);
  EXPECT_EQ(image.image.encoding, "mono8");
  EXPECT_EQ(image.image.bytes, bytes.data());
  EXPECT_EQ(image.image.num_bytes, 6u);
  image.owner.reset();
  EXPECT_TRUE(alive.expired());
}

TEST(DdsMessagesTest, AnImageWithoutEncodingIsNoFile) {
  EXPECT_FALSE(ToImage(std::make_shared<const Image>()).image.encoding.empty());
  EXPECT_TRUE(ToImage(std::make_shared<const CompressedImage>()).image.encoding.empty());
}

TEST(DdsMessagesTest, CameraInfoHasAllItsNumbers) {
  CameraInfo message{};
  std::vector<double> d = {1, 2, 3, 4, 5};
  std::string model = "plumb_bob";
  message.width = 640;
  message.height = 480;
  message.distortion_model = model.data();
  message.d._buffer = d.data();
  message.d._length = 5;
  message.k[4] = 7;
  message.r[8] = 8;
  message.p[11] = 9;
  const api::CameraInfo info = ToCameraInfo(message);
  EXPECT_EQ(info.width, 640);
  EXPECT_EQ(info.height, 480);
  EXPECT_EQ(info.distortion_model, "plumb_bob");
  EXPECT_EQ(info.D, d);
  EXPECT_EQ(info.K[4], 7);
  EXPECT_EQ(info.R[8], 8);
  EXPECT_EQ(info.P[11], 9);
}

TEST(DdsMessagesTest, OdometryHasTheStampOfTheSample) {
  robot::OdometryOutput output;
  output.t_ns = 1403636584763555584;
  output.T_odom_base = {{{1, 2, 3}}, {{0.5, 0.5, -0.5, 0.5}}};
  output.w_base = {{7, 8, 9}};
  output.pose_covariance[35] = 4;
  output.twist_covariance[1] = 5;
  const FrameNames frames;
  const Odometry message = ToOdometry(output, frames);
  EXPECT_EQ(message.header.stamp.sec, 1403636584);
  EXPECT_EQ(message.header.stamp.nanosec, 763555584u);
  EXPECT_STREQ(message.header.frame_id, "odom");
  EXPECT_STREQ(message.child_frame_id, "base_link");
  EXPECT_EQ(message.pose.pose.position.z, 3);
  EXPECT_EQ(message.pose.pose.orientation.w, 0.5);
  EXPECT_EQ(message.pose.pose.orientation.y, -0.5);
  EXPECT_EQ(message.twist.twist.angular.x, 7);
  EXPECT_EQ(message.pose.covariance[35], 4);
  EXPECT_EQ(message.twist.covariance[1], 5);
}

TEST(DdsMessagesTest, MarkersPointToWhatTheyHave) {
  robot::Marker line;
  line.type = robot::Marker::kLineStrip;
  line.points = {{{0, 0, 0}}, {{1, 2, 3}}};
  line.colours = {{{1, 0, 0, 1}}, {{0, 1, 0, 1}}};
  line.text = "floor";
  const std::vector<robot::Marker> markers = {line, robot::RemovalOfAll()};
  const FrameNames frames;
  const MarkersMessage message = MarkersMessage(markers, frames);
  ASSERT_EQ(message.message.markers._length, 2u);
  const Marker& first = message.message.markers._buffer[0];
  ASSERT_EQ(first.points._length, 2u);
  EXPECT_EQ(first.points._buffer[1].y, 2);
  ASSERT_EQ(first.colors._length, 2u);
  EXPECT_EQ(first.colors._buffer[1].g, 1);
  EXPECT_STREQ(first.text, "floor");
  EXPECT_EQ(first.pose.orientation.w, 1);
  EXPECT_EQ(message.message.markers._buffer[1].action, 3);
}

TEST(DdsMessagesTest, DiagnosticsHaveTheirValues) {
  const robot::Diagnosis diagnosis{robot::Diagnosis::Level::kError, "no images", {{"pairs", "7"}}};
  const DiagnosticMessage message(diagnosis, "facet", 5);
  ASSERT_EQ(message.message.status._length, 1u);
  const DiagnosticStatus& status = message.message.status._buffer[0];
  EXPECT_EQ(status.level, 2);
  EXPECT_STREQ(status.name, "facet: odometry");
  EXPECT_STREQ(status.message, "no images");
  ASSERT_EQ(status.values._length, 1u);
  EXPECT_STREQ(status.values._buffer[0].value, "7");
}

}  // namespace
}  // namespace facet::dds
