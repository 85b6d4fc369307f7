// SPDX-License-Identifier: BSD-2-Clause
#include "facet/messages/message_image.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/io/errors.h"
#include "facet/io/sample_depth.h"
#include "facet/testing/io/test_images.h"

namespace facet {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

ImageMessage Message(const std::string& encoding,
                     std::uint32_t width,
                     std::uint32_t height,
                     const std::vector<std::uint8_t>& data) {
  ImageMessage message;
  message.encoding = encoding;
  message.width = width;
  message.height = height;
  message.step = static_cast<std::uint32_t>(data.size() / std::max(1U, height));
  message.data = data;
  return message;
}

std::vector<int> Decode(const ImageMessage& message, int bits = 16) {
  ImageReader reader;
  cv::Mat grey;
  MessageImage(message, bits, "the bag").Decode({}, reader, grey);
  return {grey.begin<std::uint8_t>(), grey.end<std::uint8_t>()};
}

std::string Complaint(const ImageMessage& message) {
  try {
    Decode(message);
  } catch (const InputError& error) {
    return error.what();
  }
  return "none";
}

TEST(MessageImageTest, GreyAndColour) {
  const std::vector<std::uint8_t> grey = {1, 2, 3, 4};
  EXPECT_THAT(Decode(Message("mono8", 2, 2, grey)), ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(Decode(Message("8UC1", 1, 2, grey)), ElementsAre(1, 3)) << "with gaps between rows";
  const std::vector<std::uint8_t> red_first = {200, 0, 0, 10, 10, 10};
  EXPECT_THAT(Decode(Message("rgb8", 2, 1, red_first)), ElementsAre(60, 10));
  EXPECT_THAT(Decode(Message("bgr8", 2, 1, red_first)), ElementsAre(23, 10));
  const std::vector<std::uint8_t> with_alpha = {200, 0, 0, 77};
  EXPECT_THAT(Decode(Message("rgba8", 1, 1, with_alpha)), ElementsAre(60));
  EXPECT_THAT(Decode(Message("bgra8", 1, 1, with_alpha)), ElementsAre(23));
  EXPECT_THAT(Decode(Message("yuv422", 2, 1, {128, 50, 128, 60})), ElementsAre(50, 60));
  EXPECT_THAT(Decode(Message("yuv422_yuy2", 2, 1, {50, 128, 60, 128})), ElementsAre(50, 60));
}

TEST(MessageImageTest, SixteenBits) {
  const std::vector<std::uint8_t> little = {0x34, 0x12, 0xFF, 0xFF};
  ImageMessage message = Message("mono16", 2, 1, little);
  EXPECT_THAT(Decode(message), ElementsAre(0x12, 255));
  ImageReader reader;
  EXPECT_EQ(LargestSample(message, reader), 0xFFFF);
  message.is_big_endian = true;
  EXPECT_THAT(Decode(message), ElementsAre(0x34, 255));
  const std::vector<std::uint8_t> right_aligned = {0x00, 0x08, 0xFF, 0x0F};
  EXPECT_EQ(UsedSampleBits(LargestSample(Message("16UC1", 2, 1, right_aligned), reader)), 12);
  EXPECT_THAT(Decode(Message("16UC1", 2, 1, right_aligned), 12), ElementsAre(128, 255));
  EXPECT_EQ(UsedSampleBits(1023), 10);
  EXPECT_EQ(LargestSample(Message("mono8", 4, 1, little), reader), 0);
}

TEST(MessageImageTest, BayerPatternsOfAGreyWorldAreGrey) {
  for (const char* pattern : {"rggb", "bggr", "gbrg", "grbg"}) {
    const std::vector<std::uint8_t> data(6 * 6, 90);
    for (const int value : Decode(Message("bayer_" + std::string(pattern) + "8", 6, 6, data)))
      EXPECT_EQ(value, 90);
  }
}

TEST(MessageImageTest, BayerPatternsKnowWhereRedIs) {
  // Only red photosites are bright: grey is 0.299 of red, wherever the pattern puts it.
  const auto centre = [](const char* encoding, int red_x, int red_y) {
    std::vector<std::uint8_t> data(8 * 8, 0);
    for (int y = red_y; y < 8; y += 2) {
      for (int x = red_x; x < 8; x += 2)
        data[static_cast<std::size_t>(8 * y + x)] = 200;
    }
    return Decode(Message(encoding, 8, 8, data))[8 * 4 + 4];
  };
  EXPECT_NEAR(centre("bayer_rggb8", 0, 0), 60, 1);
  EXPECT_NEAR(centre("bayer_bggr8", 1, 1), 60, 1);
  EXPECT_NEAR(centre("bayer_grbg8", 1, 0), 60, 1);
  EXPECT_NEAR(centre("bayer_gbrg8", 0, 1), 60, 1);
}

TEST(MessageImageTest, Files) {
  const TestImage image{2, 1, 1, {40, 50}};
  const std::string png = EncodePng(image);
  ImageMessage message;
  const std::vector<std::uint8_t> bytes(png.begin(), png.end());
  message.data = bytes;
  EXPECT_THAT(Decode(message), ElementsAre(40, 50));
}

TEST(MessageImageTest, SaysWhatIsWrong) {
  const std::vector<std::uint8_t> data(100, 0);
  EXPECT_THAT(Complaint(Message("mono8", 40, 10, data)), HasSubstr("has only 100 bytes"));
  EXPECT_THAT(Complaint(Message("h264", 10, 10, data)), HasSubstr("'h264'; known are mono8"));
  EXPECT_THAT(Complaint(Message("mono8", 0, 10, data)), HasSubstr("is not usable"));
  EXPECT_THAT(Complaint(Message("mono8", 0xFFFFFFFF, 0xFFFFFFFF, data)), HasSubstr("not usable"));
  EXPECT_THAT(Complaint(Message("bayer_rggb8", 2, 2, data)), HasSubstr("few pixels"));
}

TEST(MessageImageTest, OtherSizesThanWantedAreNotDecoded) {
  const std::vector<std::uint8_t> data(6, 9);
  ImageReader reader;
  cv::Mat grey(2, 2, CV_8UC1, cv::Scalar(1));
  const MessageImage image(Message("mono8", 3, 2, data), 16, "the bag");
  EXPECT_EQ(image.Decode({2, 2}, reader, grey), cv::Size(3, 2));
  EXPECT_EQ(grey.at<std::uint8_t>(0, 0), 1);
}

}  // namespace
}  // namespace facet
