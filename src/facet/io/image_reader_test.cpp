// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/image_reader.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/io/errors.h"
#include "facet/io/png_writer.h"
#include "facet/testing/io/test_images.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

using ::testing::HasSubstr;

TestImage RandomImage(int channels, int max_value, int width = 37, int height = 23) {
  Rng rng(11);
  TestImage image{width, height, channels, {}};
  for (int i = 0; i < width * height * channels; ++i) {
    image.samples.push_back(static_cast<std::uint16_t>(rng.Index(max_value + 1)));
  }
  return image;
}

cv::Mat DecodeImage(const std::string& bytes) {
  TempFolder folder;
  WriteText(folder / "image.xyz", bytes);
  cv::Mat image;
  ImageReader().Read(folder / "image.xyz", image);
  return image;
}

std::string ImageErrorOf(const std::string& bytes) {
  try {
    DecodeImage(bytes);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

/// Largest difference between the decoded image and what `expected` says of a pixel's samples.
template <class Expected>
double WorstError(const cv::Mat& decoded, const TestImage& image, const Expected& expected) {
  EXPECT_EQ(decoded.type(), CV_8UC1);
  EXPECT_EQ(decoded.cols, image.width);
  EXPECT_EQ(decoded.rows, image.height);
  double worst = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const std::uint16_t* s =
          &image.samples[static_cast<std::size_t>((y * image.width + x) * image.channels)];
      worst = std::max(worst, std::abs(expected(s) - decoded.at<std::uint8_t>(y, x)));
    }
  }
  return worst;
}

double Grey(const std::uint16_t* s) {
  return s[0];
}
double Luma(const std::uint16_t* s) {
  return 0.299 * s[0] + 0.587 * s[1] + 0.114 * s[2];
}

TEST(ImageReaderTest, PngThatWasWritten) {
  const TempFolder folder;
  const cv::Mat rgb = (cv::Mat_<cv::Vec3b>(1, 3) << cv::Vec3b(200, 0, 0),
                       cv::Vec3b(0, 200, 0),
                       cv::Vec3b(0, 0, 200));
  cv::Mat read;
  WritePng(folder / "rgb.png", rgb);
  ImageReader().Read(folder / "rgb.png", read);
  EXPECT_NEAR(read.at<std::uint8_t>(0, 0), 0.299 * 200, 1);
  EXPECT_NEAR(read.at<std::uint8_t>(0, 1), 0.587 * 200, 1);
  EXPECT_NEAR(read.at<std::uint8_t>(0, 2), 0.114 * 200, 1);
  const cv::Mat grey = (cv::Mat_<std::uint8_t>(2, 1) << 7, 250);
  WritePng(folder / "grey.png", grey);
  ImageReader().Read(folder / "grey.png", read);
  EXPECT_EQ(cv::countNonZero(read != grey), 0);
}

TEST(ImageReaderTest, PngOfEveryKind) {
  const TestImage grey = RandomImage(1, 255), grey_alpha = RandomImage(2, 255);
  const TestImage rgb = RandomImage(3, 255), rgba = RandomImage(4, 255);
  EXPECT_EQ(WorstError(DecodeImage(EncodePng(grey)), grey, Grey), 0);
  EXPECT_EQ(WorstError(DecodeImage(EncodePng(grey, {8, true})), grey, Grey), 0);
  EXPECT_EQ(WorstError(DecodeImage(EncodePng(grey_alpha)), grey_alpha, Grey), 0);
  EXPECT_LE(WorstError(DecodeImage(EncodePng(rgb)), rgb, Luma), 0.51);
  EXPECT_LE(WorstError(DecodeImage(EncodePng(rgb, {8, true})), rgb, Luma), 0.51);
  EXPECT_LE(WorstError(DecodeImage(EncodePng(rgba)), rgba, Luma), 0.51);
  const TestImage bits = RandomImage(1, 1), nibbles = RandomImage(1, 15);
  EXPECT_EQ(
      WorstError(DecodeImage(EncodePng(bits, {1})), bits, [](auto s) { return 255.0 * s[0]; }), 0);
  EXPECT_EQ(
      WorstError(DecodeImage(EncodePng(nibbles, {4})), nibbles, [](auto s) { return 17.0 * s[0]; }),
      0);
  EXPECT_EQ(WorstError(DecodeImage(EncodePng(nibbles, {4, false, true})),
                       nibbles,
                       [](auto s) { return 255.0 - s[0]; }),
            0);
}

TEST(ImageReaderTest, Png16BitIsScaled) {
  const auto scaled = [](const std::uint16_t* s) { return std::round(s[0] / 257.0); };
  const TestImage grey = RandomImage(1, 65535), grey_alpha = RandomImage(2, 65535);
  EXPECT_EQ(WorstError(DecodeImage(EncodePng(grey, {16})), grey, scaled), 0);
  EXPECT_EQ(WorstError(DecodeImage(EncodePng(grey_alpha, {16})), grey_alpha, scaled), 0);
  const TestImage rgb = RandomImage(3, 65535);
  const auto luma = [](const std::uint16_t* s) { return Luma(s) / 257; };
  EXPECT_LE(WorstError(DecodeImage(EncodePng(rgb, {16})), rgb, luma), 1.01);
}

TEST(ImageReaderTest, JpegGreyAndColour) {
  TestImage grey{64, 48, 1, {}}, colour{64, 48, 3, {}};
  for (int i = 0; i < 64 * 48; ++i) {
    const auto v = static_cast<std::uint16_t>(2 * (i % 64) + i / 64);
    grey.samples.push_back(v);
    for (int c = 0; c < 3; ++c)
      colour.samples.push_back(static_cast<std::uint16_t>(v + 10 * c));
  }
  EXPECT_LE(WorstError(DecodeImage(EncodeJpeg(grey, 98)), grey, Grey), 3);
  EXPECT_LE(WorstError(DecodeImage(EncodeJpeg(colour, 98)), colour, Luma), 4);
}

TEST(ImageReaderTest, LosslessWebpIsExact) {
  TestImage grey = RandomImage(3, 255);
  for (std::size_t i = 0; i < grey.samples.size(); ++i)
    grey.samples[i] = grey.samples[i - i % 3];
  EXPECT_EQ(WorstError(DecodeImage(EncodeWebpLossless(grey)), grey, Grey), 0);
  const TestImage rgb = RandomImage(3, 255);
  EXPECT_LE(WorstError(DecodeImage(EncodeWebpLossless(rgb)), rgb, Luma), 0.51);
}

TEST(ImageReaderTest, PgmBinaryAndText) {
  const cv::Mat binary =
      DecodeImage("P5 # comment\n# more\n3 2\n255\n" + std::string("\0\1\2\3\4\xFF", 6));
  EXPECT_EQ(binary.at<std::uint8_t>(0, 2), 2);
  EXPECT_EQ(binary.at<std::uint8_t>(1, 2), 255);
  const cv::Mat text = DecodeImage("P2\n3 2\n15\n0 1 2\n3 # half\n 4 15\n");
  EXPECT_EQ(text.at<std::uint8_t>(0, 1), 17);
  EXPECT_EQ(text.at<std::uint8_t>(1, 2), 255);
  const cv::Mat deep = DecodeImage("P5\n2 1\n65535\n" + std::string("\x80\x80\xFF\xFF", 4));
  EXPECT_EQ(deep.at<std::uint8_t>(0, 0), 128);
  EXPECT_EQ(deep.at<std::uint8_t>(0, 1), 255);
}

TEST(ImageReaderTest, EveryTruncationIsAnError) {
  const std::vector<std::string> files = {EncodePng(RandomImage(1, 255)),
                                          EncodePng(RandomImage(3, 65535), {16, true}),
                                          EncodeJpeg(RandomImage(1, 255), 90),
                                          EncodeJpeg(RandomImage(3, 255), 90),
                                          EncodeWebpLossless(RandomImage(3, 255)),
                                          "P5\n37 23\n255\n" + std::string(37 * 23, 'x'),
                                          "P2\n2 2\n9\n1 2 3 4"};
  for (const std::string& file : files) {
    const std::size_t step = std::max<std::size_t>(1, file.size() / 60);
    for (std::size_t size = 0; size + 1 < file.size(); size += step) {
      EXPECT_NE(ImageErrorOf(file.substr(0, size)), "no error") << size << " of " << file.size();
    }
  }
}

TEST(ImageReaderTest, DamagedBytesNeverCrash) {
  Rng rng(5);
  int num_errors = 0;
  for (const std::string& good : {EncodePng(RandomImage(3, 255)),
                                  EncodeJpeg(RandomImage(3, 255), 90),
                                  EncodeWebpLossless(RandomImage(3, 255)),
                                  std::string("P2\n2 2\n9\n1 2 3 4\n")}) {
    for (int trial = 0; trial < 150; ++trial) {
      std::string bad = good;
      for (int k = 0; k < 3; ++k) {
        bad[static_cast<std::size_t>(rng.Index(static_cast<int>(bad.size())))] =
            static_cast<char>(rng.Index(256));
      }
      num_errors += ImageErrorOf(bad) == "no error" ? 0 : 1;
    }
  }
  EXPECT_GT(num_errors, 200);
}

TEST(ImageReaderTest, ErrorsNameTheFileAndTheReason) {
  EXPECT_THAT(ImageErrorOf("BM123456"), HasSubstr("image.xyz: not a PNG, JPEG, WebP or PGM image"));
  EXPECT_THAT(ImageErrorOf("BM123456"), HasSubstr("42 4D 31 32"));
  EXPECT_THAT(ImageErrorOf(""), HasSubstr("the file is empty"));
  EXPECT_THAT(ImageErrorOf("P5\n99999 1\n255\n"), HasSubstr("PGM"));
  EXPECT_THAT(ImageErrorOf("P5\n20000 1\n255\n"), HasSubstr("image size 20000 x 1"));
  const std::string png = EncodePng(RandomImage(1, 255));
  EXPECT_THAT(ImageErrorOf(png.substr(0, png.size() / 2)), HasSubstr("damaged or truncated PNG"));
  cv::Mat image;
  EXPECT_THROW(ImageReader().Read("/nonexistent.png", image), InputError);
}

std::string BigEndian(std::uint32_t value, int num_bytes) {
  std::string bytes;
  for (int i = num_bytes - 1; i >= 0; --i)
    bytes += static_cast<char>(value >> 8 * i & 0xff);
  return bytes;
}

std::uint32_t Crc32(std::string_view bytes) {
  std::uint32_t crc = 0xffffffff;
  for (const char c : bytes) {
    crc ^= static_cast<std::uint8_t>(c);
    for (int bit = 0; bit < 8; ++bit)
      crc = crc >> 1 ^ ((crc & 1) != 0 ? 0xedb88320 : 0);
  }
  return ~crc;
}

// Small files whose headers promise a square image with sides of `size` pixels.
std::vector<std::string> HeadersOfSize(std::uint32_t size) {
  TestImage colour = RandomImage(3, 255);
  std::string png = EncodePng(colour);
  png.replace(16, 8, BigEndian(size, 4) + BigEndian(size, 4));
  png.replace(29, 4, BigEndian(Crc32(std::string_view(png).substr(12, 17)), 4));
  std::string jpeg = EncodeJpeg(colour, 80);
  jpeg.replace(jpeg.find("\xFF\xC0") + 5, 4, BigEndian(size, 2) + BigEndian(size, 2));
  std::string webp = EncodeWebpLossless(colour);
  const std::size_t vp8l = webp.find("VP8L") + 9;
  const std::uint32_t alpha_and_version = static_cast<std::uint8_t>(webp[vp8l + 3]) & 0xf0u;
  const std::uint32_t sides = (size - 1) | (size - 1) << 14 | alpha_and_version << 24;
  for (std::size_t i = 0; i < 4; ++i)
    webp[vp8l + i] = static_cast<char>(sides >> 8 * i & 0xff);
  const std::string side = std::to_string(size);
  return {png,
          jpeg,
          webp,
          "P5\n" + side + " " + side + "\n255\n123",
          "P2 " + side + " " + side + " 15 3"};
}

TEST(ImageReaderTest, ImmenseImagesAreRefusedByTheirHeader) {
  for (const std::string& image : HeadersOfSize(16000))
    EXPECT_THAT(ImageErrorOf(image), HasSubstr("image size 16000 x 16000 is not usable"));
}

TEST(ImageReaderTest, AnImageOfAnotherSizeIsNotDecoded) {
  const TempFolder folder;
  for (const std::string& content : HeadersOfSize(4000)) {
    WriteText(folder / "image", content);
    cv::Mat image(2, 3, CV_8UC1, 7.0);
    const cv::Size size = ImageReader().ReadOfSize(folder / "image", {3, 2}, image);
    EXPECT_EQ(size, cv::Size(4000, 4000));
    EXPECT_EQ(image.size(), cv::Size(3, 2)) << "it was decoded";
    // Of the right size, what follows the header counts, and is damaged.
    EXPECT_THROW(ImageReader().ReadOfSize(folder / "image", size, image), InputError);
  }
}

TEST(ImageReaderTest, ReusesTheBufferUnlessItIsShared) {
  TempFolder folder;
  WriteText(folder / "a", EncodePng(RandomImage(1, 255)));
  ImageReader reader;
  cv::Mat image;
  reader.Read(folder / "a", image);
  const std::uint8_t* memory = image.data;
  reader.Read(folder / "a", image);
  EXPECT_EQ(image.data, memory);
  const cv::Mat kept = image;
  reader.Read(folder / "a", image);
  EXPECT_NE(image.data, kept.data);
}

}  // namespace
}  // namespace facet
