// SPDX-License-Identifier: BSD-2-Clause
#include "facet/recording/sensor_messages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/io/errors.h"
#include "facet/testing/recording/test_messages.h"

namespace facet {
namespace {

std::span<const std::uint8_t> AsBytes(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

class SensorMessagesTest : public ::testing::TestWithParam<MessageEncoding> {};

TEST_P(SensorMessagesTest, Imu) {
  ImuSample sample;
  sample.t.ns = 1403636580838555648;
  sample.gyro = {0.1, -0.2, 1e-300};
  sample.accel = {9.81, -3, 0.5};
  // Frames of several lengths: alignment depends on them.
  for (const char* frame : {"", "a", "imu", "imu_link_0"}) {
    const std::string bytes = ImuBytes(GetParam(), sample, frame);
    const ImuMessage message = ReadImuMessage(AsBytes(bytes), GetParam());
    EXPECT_EQ(message.header.t, sample.t);
    EXPECT_EQ(message.header.frame, frame);
    EXPECT_EQ(message.sample.gyro, sample.gyro);
    EXPECT_EQ(message.sample.accel, sample.accel);
    for (std::size_t size = 0; size < bytes.size() - 8 * 9; ++size)
      EXPECT_THROW(ReadImuMessage(AsBytes(bytes.substr(0, size)), GetParam()), InputError);
  }
}

TEST_P(SensorMessagesTest, Images) {
  TestRawImage image{3, 2, "mono8", "abc_def", 4, false};
  const std::string bytes = ImageBytes(GetParam(), Timestamp{5000000001}, "cam", image);
  const ImageMessage message = ReadImageMessage(AsBytes(bytes), GetParam());
  EXPECT_EQ(message.header.t.ns, 5000000001);
  EXPECT_EQ(message.width, 3u);
  EXPECT_EQ(message.height, 2u);
  EXPECT_EQ(message.step, 4u);
  EXPECT_EQ(message.encoding, "mono8");
  EXPECT_EQ(std::string(message.data.begin(), message.data.end()), "abc_def");
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_THROW(ReadImageMessage(AsBytes(bytes.substr(0, size)), GetParam()), InputError);

  const std::string compressed = CompressedImageBytes(GetParam(), Timestamp{1}, "the file");
  const ImageMessage file = ReadCompressedImageMessage(AsBytes(compressed), GetParam());
  EXPECT_EQ(file.encoding, "");
  EXPECT_EQ(std::string(file.data.begin(), file.data.end()), "the file");
}

TEST_P(SensorMessagesTest, CameraInfo) {
  CameraInfoMessage info;
  info.header = {Timestamp{17}, "/left_optical"};
  info.width = 752;
  info.height = 480;
  info.distortion_model = "plumb_bob";
  info.D = {1, 2, 3, 4, 5};
  info.K = {10, 0, 20, 0, 30, 40, 0, 0, 1};
  info.R = {1, 2, 3, 4, 5, 6, 7, 8, 9};
  info.P = {9, 8, 7, 6, 5, 4, 3, 2, 1, 0, -1, -2};
  const std::string bytes = CameraInfoBytes(GetParam(), info);
  const CameraInfoMessage read = ReadCameraInfoMessage(AsBytes(bytes), GetParam());
  EXPECT_EQ(read.header.frame, "left_optical");
  EXPECT_EQ(read.width, 752u);
  EXPECT_EQ(read.height, 480u);
  EXPECT_EQ(read.D, info.D);
  EXPECT_EQ(read.K, info.K);
  EXPECT_EQ(read.R, info.R);
  EXPECT_EQ(read.P, info.P);
}

TEST_P(SensorMessagesTest, Transforms) {
  FrameTransform transform{"imu", "cam0", SE3(Quaterniond(0.5, 0.5, -0.5, 0.5), {1, 2, 3})};
  const std::string bytes = TransformsBytes(GetParam(), {transform, transform});
  const auto read = ReadTransformsMessage(AsBytes(bytes), GetParam());
  ASSERT_EQ(read.size(), 2u);
  EXPECT_EQ(read[1].parent, "imu");
  EXPECT_EQ(read[1].child, "cam0");
  EXPECT_EQ(read[1].T_parent_child.p, transform.T_parent_child.p);
  EXPECT_EQ(read[1].T_parent_child.q.coeffs(), transform.T_parent_child.q.coeffs());
  transform.T_parent_child.q.coeffs().setZero();
  const std::string bad = TransformsBytes(GetParam(), {transform});
  EXPECT_THROW(ReadTransformsMessage(AsBytes(bad), GetParam()), InputError);
}

INSTANTIATE_TEST_SUITE_P(Encodings,
                         SensorMessagesTest,
                         ::testing::Values(MessageEncoding::kRos1, MessageEncoding::kCdr));

TEST(SensorMessagesCdrTest, BigEndianAndUnknownKinds) {
  // A compressed image: stamp 1 s and 2 ns, frame "ab", format "", 3 bytes of data.
  const std::string big("\0\0\0\0\0\0\0\1\0\0\0\2\0\0\0\3ab\0\0\0\0\0\1\0\0\0\0\0\0\0\3xyz", 35);
  const ImageMessage image = ReadCompressedImageMessage(AsBytes(big), MessageEncoding::kCdr);
  EXPECT_EQ(image.header.t.ns, 1000000002);
  EXPECT_EQ(image.header.frame, "ab");
  EXPECT_EQ(std::string(image.data.begin(), image.data.end()), "xyz");
  std::string other = big;
  other[1] = 3;
  EXPECT_THROW(ReadCompressedImageMessage(AsBytes(other), MessageEncoding::kCdr), InputError);
  EXPECT_THROW(ReadCompressedImageMessage(AsBytes(big), MessageEncoding::kOther), InputError);
}

}  // namespace
}  // namespace facet
