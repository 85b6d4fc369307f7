// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/grey_png.h"

#include <algorithm>
#include <string>

#include <gtest/gtest.h>
#include <png.h>

#include "facet/base/random.h"
#include "facet/io/errors.h"
#include "facet/testing/io/test_images.h"

namespace facet {
namespace {

class GreyPngTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!HasGreyPngDecoder()) GTEST_SKIP() << "built without libdeflate";
  }
};

Bytes BytesOf(const std::string& file) {
  return {reinterpret_cast<const std::uint8_t*>(file.data()), file.size()};
}

/// Smooth with some noise, so that every filter is worth something.
TestImage Picture(int max_value, int width, int height) {
  Rng rng(7);
  TestImage image{width, height, 1, {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int slope = max_value * (x + 2 * y) / (width + 2 * height);
      image.samples.push_back(static_cast<std::uint16_t>(
          std::clamp(slope + rng.Index(1 + max_value / 8), 0, max_value)));
    }
  }
  return image;
}

std::string Encode(const TestImage& image, int depth, int filters, std::size_t chunk_size) {
  return EncodePng(image, {.depth = depth, .filters = filters, .chunk_size = chunk_size});
}

struct Decoded {
  bool ok = false;
  cv::Mat image;
  cv::Size found;
};

Decoded Decode(const std::string& file, int sample_bits = 16, cv::Size wanted = {}) {
  Decoded decoded;
  std::vector<std::uint8_t> scratch;
  GreyTarget target{decoded.image, wanted, sample_bits};
  decoded.ok = DecodeGreyPng(BytesOf(file), scratch, target);
  decoded.found = target.found;
  return decoded;
}

cv::Mat ByLibpng(const std::string& file, int sample_bits = 16) {
  cv::Mat image;
  std::vector<std::uint8_t> colour;
  GreyTarget target{image, {}, sample_bits};
  DecodePng(BytesOf(file), colour, target);
  return image;
}

bool AreEqual(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::countNonZero(a != b) == 0;
}

TEST_F(GreyPngTest, DecodesEveryFilterAsLibpngDoes) {
  for (const int filters : {PNG_FILTER_NONE,
                            PNG_FILTER_SUB,
                            PNG_FILTER_UP,
                            PNG_FILTER_AVG,
                            PNG_FILTER_PAETH,
                            PNG_ALL_FILTERS}) {
    for (const cv::Size size : {cv::Size(61, 47), cv::Size(1, 9), cv::Size(300, 1)}) {
      const std::string shallow = Encode(Picture(255, size.width, size.height), 8, filters, 8192);
      const Decoded decoded = Decode(shallow);
      ASSERT_TRUE(decoded.ok) << filters;
      EXPECT_TRUE(AreEqual(decoded.image, ByLibpng(shallow))) << filters << ' ' << size;
      const std::string deep = Encode(Picture(4095, size.width, size.height), 16, filters, 8192);
      for (const int bits : {10, 12, 16}) {
        const Decoded of_deep = Decode(deep, bits);
        ASSERT_TRUE(of_deep.ok) << filters;
        EXPECT_TRUE(AreEqual(of_deep.image, ByLibpng(deep, bits))) << filters << ' ' << bits;
      }
    }
  }
}

TEST_F(GreyPngTest, JoinsTheChunksOfAnImage) {
  const TestImage picture = Picture(255, 200, 100);
  const std::string file = Encode(picture, 8, PNG_ALL_FILTERS, 100);
  std::size_t num_chunks = 0;
  for (std::size_t at = file.find("IDAT"); at != std::string::npos; at = file.find("IDAT", at + 1))
    ++num_chunks;
  ASSERT_GT(num_chunks, 10u);
  const Decoded decoded = Decode(file);
  ASSERT_TRUE(decoded.ok);
  EXPECT_TRUE(AreEqual(decoded.image, ByLibpng(file)));
}

TEST_F(GreyPngTest, LeavesWhatIsNotGreyToLibpng) {
  TestImage colour = Picture(255, 30, 10);
  colour.width = 10;
  colour.channels = 3;
  EXPECT_FALSE(Decode(EncodePng(colour)).ok);
  EXPECT_FALSE(Decode(EncodePng(Picture(15, 30, 10), {4})).ok);
  EXPECT_FALSE(Decode(EncodePng(Picture(15, 30, 10), {4, false, true})).ok);
  EXPECT_FALSE(Decode(EncodePng(Picture(255, 30, 10), {8, true})).ok) << "interlaced";
  EXPECT_FALSE(Decode("").ok);
}

TEST_F(GreyPngTest, AnotherSizeIsNotDecoded) {
  const Decoded decoded = Decode(EncodePng(Picture(255, 30, 10)), 16, {31, 10});
  EXPECT_TRUE(decoded.ok);
  EXPECT_EQ(decoded.found, cv::Size(30, 10));
  EXPECT_TRUE(decoded.image.empty());
}

TEST_F(GreyPngTest, EveryChangedByteAndEveryTruncationIsNoticedOrHarmless) {
  for (const int depth : {8, 16}) {
    const std::string good =
        Encode(Picture(depth == 8 ? 255 : 4095, 40, 25), depth, PNG_ALL_FILTERS, 200);
    const cv::Mat expected = ByLibpng(good);
    for (std::size_t size = 0; size < good.size(); ++size)
      EXPECT_FALSE(Decode(good.substr(0, size)).ok) << size;
    int num_refused = 0;
    for (std::size_t i = 8; i < good.size(); ++i) {
      std::string bad = good;
      bad[i] = static_cast<char>(bad[i] ^ 0x15);
      try {
        const Decoded decoded = Decode(bad);
        num_refused += decoded.ok ? 0 : 1;
        EXPECT_TRUE(!decoded.ok || AreEqual(decoded.image, expected)) << i;
      } catch (const InputError&) {
        ADD_FAILURE() << "the checksum of the header comes first, byte " << i;
      }
    }
    EXPECT_EQ(num_refused, static_cast<int>(good.size()) - 8) << "no chunk without a checksum";
  }
}

}  // namespace
}  // namespace facet
