// SPDX-License-Identifier: BSD-2-Clause
// What is told of a run without a pose follows from what really was in the way.
#include "start_trouble.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/base/random.h"

namespace facet {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

cv::Mat Noise(int width, int height, int low, int high) {
  Rng rng(1);
  cv::Mat image(height, width, CV_8UC1);
  for (int i = 0; i < width * height; ++i)
    image.data[i] = static_cast<std::uint8_t>(low + rng.Index(high - low + 1));
  return image;
}

cv::Mat OneBit(int width, int height) {
  cv::Mat image = Noise(width, height, 0, 255);
  for (int i = 0; i < width * height; ++i)
    image.data[i] = image.data[i] > 127 ? 255 : 0;
  return image;
}

struct Case {
  cv::Mat left, right;
  std::string reason = "too few stereo landmarks";
  int num_tracks = 0;
};

std::string Explain(const Case& c) {
  StartTrouble trouble;
  for (int i = 0; i < 20; ++i) {
    trouble.AddImages({{}, c.left, c.right});
    VioOutput output;
    output.reason = i < 6 ? "collecting frames" : c.reason;
    output.num_tracks = c.num_tracks;
    trouble.AddOutput(output);
  }
  return trouble.Explain();
}

const cv::Mat kGood = Noise(320, 240, 0, 255);

TEST(StartTroubleTest, SaysWhatIsWrongWithTheImages) {
  const cv::Mat black(240, 320, CV_8UC1, 0.0), grey(240, 320, CV_8UC1, 90.0);
  EXPECT_THAT(Explain({black, black}), HasSubstr("20 of 20 left images are black or nearly so"));
  EXPECT_THAT(Explain({Noise(320, 240, 0, 6), kGood}), HasSubstr("left images are black"));
  EXPECT_THAT(Explain({grey, grey}), HasSubstr("20 of 20 left images have no texture"));
  EXPECT_THAT(Explain({kGood, black}), HasSubstr("20 of 20 right images are black"));
  EXPECT_THAT(Explain({OneBit(320, 240), kGood}), HasSubstr("left images have two grey values"));
  const cv::Mat tiny = Noise(8, 8, 0, 255);
  EXPECT_THAT(Explain({tiny, tiny}), HasSubstr("the images have 8 x 8 pixels, too few"));
  EXPECT_THAT(Explain({kGood, {}}), HasSubstr("no right images"));
  for (const cv::Mat& image : {black, grey, tiny})
    EXPECT_THAT(Explain({image, image}), Not(HasSubstr("IMU")));
}

TEST(StartTroubleTest, GoodImagesAreNotBlamed) {
  const auto of_reason = [](const std::string& reason, int num_tracks) {
    return Explain({kGood, kGood, reason, num_tracks});
  };
  EXPECT_THAT(of_reason("too few stereo landmarks", 100), HasSubstr("cameras swapped"));
  EXPECT_THAT(of_reason("too few stereo landmarks", 3), HasSubstr("too few corners"));
  EXPECT_THAT(of_reason("too little IMU", 100), HasSubstr("check the IMU's stamps"));
  EXPECT_THAT(of_reason("no IMU", 100), HasSubstr("check the IMU's stamps"));
  EXPECT_THAT(of_reason("gravity from stereo and IMU is 1.0 m/s^2", 100),
              AllOf(HasSubstr("is 1.0 m/s^2"), HasSubstr("units of the IMU")));
  EXPECT_THAT(of_reason("collecting frames", 100), HasSubstr("too short"));
}

// Without IMU the images do not matter, dark or not.
TEST(StartTroubleTest, WhatWasInTheWayMostOfTheTimeCounts) {
  const cv::Mat black(240, 320, CV_8UC1, 0.0);
  EXPECT_THAT(Explain({black, black, "no IMU"}), HasSubstr("check the IMU's stamps"));
}

}  // namespace
}  // namespace facet
