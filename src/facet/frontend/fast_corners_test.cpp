// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/fast_corners.h"

#include <gtest/gtest.h>
#include <opencv2/features2d.hpp>

#include "facet/base/check.h"
#include "facet/base/random.h"

namespace facet {
namespace {

ImageLevel LevelOf(const cv::Mat& image) {
  return {image.data, static_cast<int>(image.step[0]), image.cols, image.rows};
}

// Squares and noise, so that there are corners of every strength.
cv::Mat Clutter(int cols, int rows, Rng& rng) {
  cv::Mat image(rows, cols, CV_8UC1, cv::Scalar(90));
  for (int i = 0; i < cols * rows / 60; ++i) {
    const cv::Rect square(rng.Index(cols), rng.Index(rows), 1 + rng.Index(9), 1 + rng.Index(9));
    image(square & cv::Rect(0, 0, cols, rows)).setTo(rng.Index(256));
  }
  for (int i = 0; i < cols * rows / 3; ++i)
    image.at<std::uint8_t>(rng.Index(rows), rng.Index(cols)) +=
        static_cast<std::uint8_t>(rng.Index(30));
  return image;
}

void ExpectThoseOfOpenCv(const cv::Mat& image, const cv::Rect& cell, int threshold) {
  constexpr int kRadius = FastCorners::kRadius;
  FastCorners fast;
  std::vector<cv::KeyPoint> expected;
  const cv::Rect grown(cell.x - kRadius, cell.y - kRadius, cell.width + 6, cell.height + 6);
  cv::FAST(image(grown), expected, threshold, true);
  const std::span<const FastCorner> corners = fast.Find(LevelOf(image), cell, threshold);
  ASSERT_EQ(corners.size(), expected.size()) << cell << ", threshold " << threshold;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(corners[i].x, static_cast<int>(expected[i].pt.x) + grown.x);
    EXPECT_EQ(corners[i].y, static_cast<int>(expected[i].pt.y) + grown.y);
    EXPECT_EQ(corners[i].score, static_cast<int>(expected[i].response));
  }
}

TEST(FastCornersTest, AreThoseOfOpenCvWithTheirScores) {
  Rng rng(1);
  for (int i = 0; i < 200; ++i) {
    const cv::Mat image = Clutter(60 + rng.Index(60), 50 + rng.Index(20), rng);
    const int width = 1 + rng.Index(54), height = 1 + rng.Index(44);
    const cv::Rect cell(3 + rng.Index(image.cols - width - 5),
                        3 + rng.Index(image.rows - height - 5),
                        width,
                        height);
    ExpectThoseOfOpenCv(image, cell, 1 + rng.Index(60));
  }
}

TEST(FastCornersTest, AreFoundUpToTheBorderAndInPartsOfImages) {
  Rng rng(2);
  for (const int cols : {22, 23, 37, 38, 39, 54}) {
    const cv::Mat image = Clutter(cols, 30, rng);
    ExpectThoseOfOpenCv(image, cv::Rect(3, 3, cols - 6, 24), 10);
    const cv::Mat larger = Clutter(cols + 9, 40, rng);
    ExpectThoseOfOpenCv(larger(cv::Rect(5, 4, cols, 30)), cv::Rect(3, 3, cols - 6, 24), 10);
  }
}

TEST(FastCornersTest, AWhiteDotOnBlackHasTheLargestScore) {
  cv::Mat image(30, 30, CV_8UC1, cv::Scalar(0));
  image.at<std::uint8_t>(17, 12) = 255;
  FastCorners fast;
  const auto corners = fast.Find(LevelOf(image), cv::Rect(3, 3, 24, 24), 254);
  ASSERT_EQ(corners.size(), 1U);
  EXPECT_EQ(corners[0].x, 12);
  EXPECT_EQ(corners[0].y, 17);
  EXPECT_EQ(corners[0].score, 254);
}

TEST(FastCornersTest, ChecksWhatItReads) {
  FastCorners fast;
  const cv::Mat image = cv::Mat::zeros(40, 40, CV_8UC1);
  EXPECT_THROW(fast.Find(LevelOf(image), cv::Rect(2, 3, 9, 9), 20), CheckError);
  EXPECT_THROW(fast.Find(LevelOf(image), cv::Rect(3, 3, 35, 9), 20), CheckError);
  EXPECT_THROW(fast.Find(LevelOf(image), cv::Rect(3, 3, 9, 35), 20), CheckError);
  EXPECT_THROW(fast.Find(LevelOf(image), cv::Rect(3, 3, 9, 9), 0), CheckError);
  const cv::Mat narrow = cv::Mat::zeros(40, 21, CV_8UC1);
  EXPECT_THROW(fast.Find(LevelOf(narrow), cv::Rect(3, 3, 9, 9), 20), CheckError);
}

}  // namespace
}  // namespace facet
