// SPDX-License-Identifier: BSD-2-Clause
#include "facet/recording/topic_choice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/io/errors.h"
#include "facet/recording/sensor_messages.h"

namespace facet {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

Topic Of(const std::string& name, const char* type) {
  return {name, type, MessageEncoding::kCdr, 3};
}
Topic Image(const std::string& name) {
  return Of(name, kImageType);
}
Topic Imu(const std::string& name) {
  return Of(name, kImuType);
}

/// Names of left, right and IMU (or gyroscope and accelerometer), or the complaint.
std::string Choose(const std::vector<Topic>& topics, const std::vector<std::string>& texts = {}) {
  try {
    const TopicChoice choice = ChooseTopics(topics, ParseTopics(texts), "a.bag");
    const auto name = [&](std::optional<std::size_t> i) { return i ? " " + topics[*i].name : ""; };
    return topics[choice.left].name + " " + topics[choice.right].name + name(choice.imu) +
           name(choice.gyro) + name(choice.accel);
  } catch (const ConfigError& error) {
    return std::string("usage: ") + error.what();
  } catch (const InputError& error) {
    return std::string("input: ") + error.what();
  }
}

TEST(TopicChoiceTest, LeftAndRightByTheirNames) {
  const auto pair = [](const std::string& a, const std::string& b) {
    return Choose({Image(b), Imu("/imu"), Image(a)});
  };
  EXPECT_EQ(pair("/cam0/image_raw", "/cam1/image_raw"), "/cam0/image_raw /cam1/image_raw /imu");
  EXPECT_EQ(pair("/left/image", "/right/image"), "/left/image /right/image /imu");
  EXPECT_EQ(pair("/camera/infra1/image_rect_raw", "/camera/infra2/image_rect_raw"),
            "/camera/infra1/image_rect_raw /camera/infra2/image_rect_raw /imu");
  EXPECT_EQ(pair("/left/left_raw", "/right/right_raw"), "/left/left_raw /right/right_raw /imu");
  EXPECT_EQ(pair("/Cam_L", "/Cam_R"), "/Cam_L /Cam_R /imu");
}

TEST(TopicChoiceTest, ARealSenseHasMoreThanIsNeeded) {
  EXPECT_EQ(Choose({Image("/d/color/image_raw"),
                    Image("/d/depth/image_rect_raw"),
                    Image("/d/infra1/image_rect_raw"),
                    Image("/d/infra2/image_rect_raw"),
                    Of("/d/infra1/image_rect_raw/compressed", kCompressedImageType),
                    Imu("/d/accel/sample"),
                    Imu("/d/gyro/sample")}),
            "/d/infra1/image_rect_raw /d/infra2/image_rect_raw /d/gyro/sample /d/accel/sample");
}

TEST(TopicChoiceTest, OneImuIsTakenBeforeItsParts) {
  EXPECT_EQ(Choose({Image("/l"), Image("/r"), Imu("/gyro"), Imu("/accel"), Imu("/imu")}),
            "/l /r /imu");
}

TEST(TopicChoiceTest, AChoiceIsListed) {
  const std::vector<Topic> two_rigs = {Image("/a/left"),
                                       Image("/a/right"),
                                       Image("/b/left"),
                                       Image("/b/right"),
                                       Imu("/a/imu"),
                                       Imu("/b/imu")};
  EXPECT_THAT(Choose(two_rigs),
              AllOf(HasSubstr("usage: a.bag: which topics"),
                    HasSubstr("--topics left=NAME right=NAME"),
                    HasSubstr("/b/right (sensor_msgs/Image, 3 messages)")));
  EXPECT_THAT(Choose(two_rigs, {"left=/a/left", "right=/a/right"}),
              HasSubstr("which topic is the IMU"));
  EXPECT_EQ(Choose(two_rigs, {"left=/b/left", "right=b/right", "imu=/a/imu"}),
            "/b/left /b/right /a/imu");
  EXPECT_EQ(Choose(two_rigs, {"left=/b/left", "right=/b/right", "gyro=/a/imu", "accel=/b/imu"}),
            "/b/left /b/right /a/imu /b/imu");
}

TEST(TopicChoiceTest, SaysWhatIsMissing) {
  EXPECT_THAT(Choose({Image("/left"), Imu("/imu")}), HasSubstr("input: a.bag: two topics"));
  EXPECT_THAT(Choose({Image("/left"), Image("/right")}),
              HasSubstr("input: a.bag: no topic of type"));
  EXPECT_THAT(Choose({Image("/left"), Image("/right"), Imu("/imu")}, {"left=/x", "right=/right"}),
              AllOf(HasSubstr("usage: --topics left=/x"), HasSubstr("/right (")));
  EXPECT_THAT(Choose({}, {"middle=/x"}), HasSubstr("usage: --topics middle=/x"));
  EXPECT_THAT(Choose({Image("/l"), Image("/r"), Imu("/i")}, {"left=/l"}), HasSubstr("both left="));
}

}  // namespace
}  // namespace facet
