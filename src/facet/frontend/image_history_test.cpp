// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/image_history.h"

#include <set>

#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/geometry/so3.h"

namespace facet {
namespace {

constexpr double kHistoryFocal_px = 450;

cv::Mat NoisePicture(std::uint64_t seed, int cols = 64) {
  Rng rng(seed);
  cv::Mat image(48, cols, CV_8UC1);
  for (int i = 0; i < image.rows * image.cols; ++i)
    image.data[i] = static_cast<std::uint8_t>(rng.Index(256));
  return image;
}

RepeatedImage::Motion TurnBy(double angle) {
  return {SE3(ExpSO3({0, angle, 0}), Vector3d::Zero()), 0.5, 0};
}

TEST(FingerprintTest, DependsOnEveryPixelAndOnTheSize) {
  for (const int cols : {64, 61}) {
    const cv::Mat image = NoisePicture(1, cols);
    std::set<std::uint64_t> seen = {Fingerprint(image)};
    for (int i = 0; i < image.rows * image.cols; ++i) {
      for (const int bit : {0, 7}) {
        cv::Mat changed = image.clone();
        changed.data[i] ^= static_cast<std::uint8_t>(1 << bit);
        EXPECT_TRUE(seen.insert(Fingerprint(changed)).second) << i << " of " << cols;
      }
    }
    EXPECT_TRUE(seen.insert(Fingerprint(image.rowRange(0, 47))).second);
  }
  EXPECT_NE(Fingerprint(cv::Mat::zeros(10, 20, CV_8UC1)),
            Fingerprint(cv::Mat::zeros(20, 10, CV_8UC1)));
}

TEST(FingerprintTest, DoesNotDependOnWhereTheRowsLie) {
  const cv::Mat image = NoisePicture(1, 61);
  cv::Mat large(60, 80, CV_8UC1, 7.0);
  image.copyTo(large(cv::Rect(5, 5, 61, 48)));
  EXPECT_EQ(Fingerprint(large(cv::Rect(5, 5, 61, 48))), Fingerprint(image));
}

TEST(ImageHistoryTest, AnOldImageComesAgain) {
  ImageHistory history(kHistoryFocal_px);
  for (std::uint64_t i = 0; i < 50; ++i)
    EXPECT_FALSE(history.Add(NoisePicture(i), TurnBy(0.01)));
  for (const std::uint64_t old : {49, 48, 20, 0})
    EXPECT_TRUE(history.Add(NoisePicture(old), TurnBy(0.01))) << old;
  EXPECT_FALSE(history.Add(NoisePicture(50), TurnBy(0.01)));
}

TEST(ImageHistoryTest, WhatIsLongAgoIsForgotten) {
  ImageHistory history(kHistoryFocal_px);
  for (std::uint64_t i = 0; i < 101; ++i)
    history.Add(NoisePicture(i), TurnBy(0.01));
  EXPECT_TRUE(history.Add(NoisePicture(1), TurnBy(0.01)));
  EXPECT_FALSE(history.Add(NoisePicture(0), TurnBy(0.01)));
}

// Images without noise: the same place looks the same.
TEST(ImageHistoryTest, ACameraThatIsBackWhereItWasMaySeeTheSame) {
  ImageHistory history(kHistoryFocal_px);
  history.Add(NoisePicture(1), TurnBy(0));
  history.Add(NoisePicture(2), TurnBy(0.1));
  EXPECT_FALSE(history.Add(NoisePicture(1), TurnBy(-0.1)));
  EXPECT_TRUE(history.Add(NoisePicture(2), TurnBy(0.05)));
}

}  // namespace
}  // namespace facet
