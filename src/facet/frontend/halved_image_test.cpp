// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/halved_image.h"

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "facet/base/check.h"
#include "facet/base/random.h"

namespace facet {
namespace {

cv::Mat RandomPixels(int cols, int rows, bool only_extremes, Rng& rng) {
  cv::Mat image(rows, cols, CV_8UC1);
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < cols; ++x)
      image.at<std::uint8_t>(y, x) =
          static_cast<std::uint8_t>(only_extremes ? 255 * rng.Index(2) : rng.Index(256));
  }
  return image;
}

int NumDifferent(const cv::Mat& a, const cv::Mat& b) {
  EXPECT_EQ(a.size(), b.size());
  return a.size() == b.size() ? cv::countNonZero(a != b) : -1;
}

TEST(HalvedImageTest, HasThePixelsOfPyrDown) {
  Rng rng(1);
  ImageHalver halver, narrow(8);
  cv::Mat half, expected;
  for (int i = 0; i < 300; ++i) {
    const int cols = 4 + rng.Index(i < 100 ? 12 : 200), rows = 4 + rng.Index(40);
    const cv::Mat image = RandomPixels(cols, rows, i % 3 == 0, rng);
    halver.Halve(image, half);
    cv::pyrDown(image, expected);
    EXPECT_EQ(NumDifferent(half, expected), 0) << cols << " x " << rows;
    narrow.Halve(image, half);
    EXPECT_EQ(NumDifferent(half, expected), 0) << cols << " x " << rows;
  }
}

TEST(HalvedImageTest, WhiteStaysWhite) {
  ImageHalver halver;
  cv::Mat half;
  halver.Halve(cv::Mat(33, 70, CV_8UC1, cv::Scalar(255)), half);
  EXPECT_EQ(NumDifferent(half, cv::Mat(17, 35, CV_8UC1, cv::Scalar(255))), 0);
}

TEST(HalvedImageTest, ReadsPartsOfImagesAndKeepsTheMemoryOfTheHalf) {
  Rng rng(2);
  const cv::Mat image = RandomPixels(90, 60, false, rng);
  const cv::Mat part = image(cv::Rect(7, 5, 75, 50));
  ImageHalver halver;
  cv::Mat half, expected;
  halver.Halve(part, half);
  const std::uint8_t* const data = half.data;
  cv::pyrDown(part.clone(), expected);
  EXPECT_EQ(NumDifferent(half, expected), 0);
  halver.Halve(part, half);
  EXPECT_EQ(half.data, data);
}

TEST(HalvedImageTest, RefusesWhatItCannotHalve) {
  ImageHalver halver;
  cv::Mat half;
  EXPECT_THROW(halver.Halve(cv::Mat::zeros(3, 8, CV_8UC1), half), CheckError);
  EXPECT_THROW(halver.Halve(cv::Mat::zeros(8, 8, CV_8UC3), half), CheckError);
  EXPECT_THROW(halver.Halve(cv::Mat(), half), CheckError);
}

}  // namespace
}  // namespace facet
