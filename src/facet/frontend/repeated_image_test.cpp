// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/repeated_image.h"

#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/geometry/so3.h"

namespace facet {
namespace {

constexpr double kFocal_px = 450;

cv::Mat Noise(std::uint64_t seed) {
  Rng rng(seed);
  cv::Mat image(48, 64, CV_8UC1);
  for (int i = 0; i < image.rows * image.cols; ++i)
    image.data[i] = static_cast<std::uint8_t>(rng.Index(256));
  return image;
}

RepeatedImage::Motion Turn(double angle) {
  return {SE3(ExpSO3({0, angle, 0}), Vector3d::Zero()), 0.5, 0};
}

RepeatedImage::Motion Step(double x_m) {
  return {SE3(Quaterniond::Identity(), {x_m, 0, 0}), 0.5, 0};
}

TEST(AreSameImageTest, ComparesPixelsAndSize) {
  const cv::Mat a = Noise(1);
  cv::Mat b = a.clone();
  EXPECT_TRUE(AreSameImage(a, b));
  b.at<std::uint8_t>(47, 63) ^= 1;
  EXPECT_FALSE(AreSameImage(a, b));
  EXPECT_FALSE(AreSameImage(a, a.rowRange(0, 20)));
  EXPECT_FALSE(AreSameImage({}, {}));
  // Part of a larger image: the rows are not one after another.
  cv::Mat large(60, 80, CV_8UC1, 7.0);
  a.copyTo(large(cv::Rect(5, 5, 64, 48)));
  EXPECT_TRUE(AreSameImage(a, large(cv::Rect(5, 5, 64, 48))));
}

TEST(IsBlankTest, LooksAtEveryPixel) {
  cv::Mat image(48, 64, CV_8UC1, 90.0);
  EXPECT_TRUE(IsBlank(image));
  EXPECT_TRUE(IsBlank(image(cv::Rect(5, 5, 20, 10))));
  image.at<std::uint8_t>(47, 63) = 91;
  EXPECT_FALSE(IsBlank(image));
  EXPECT_FALSE(IsBlank(Noise(1)));
  EXPECT_FALSE(IsBlank({}));
}

TEST(RepeatedImageTest, AnImageThatComesAgainWhileTheCameraTurns) {
  RepeatedImage watch(kFocal_px);
  EXPECT_FALSE(watch.Add(Noise(1), Turn(0)));
  EXPECT_TRUE(watch.Add(Noise(1), Turn(0.01)));
  EXPECT_TRUE(watch.Add(Noise(1), Turn(0.01)));
  EXPECT_FALSE(watch.Add(Noise(2), Turn(0.01)));
  EXPECT_TRUE(watch.Add(Noise(2), Step(0.05)));
}

TEST(RepeatedImageTest, SlowMotionAddsUp) {
  RepeatedImage watch(kFocal_px);
  watch.Add(Noise(1), Turn(0));
  EXPECT_FALSE(watch.Add(Noise(1), Turn(0.0006)));
  EXPECT_TRUE(watch.Add(Noise(1), Turn(0.0006)));
  // To and fro does not.
  RepeatedImage shaking(kFocal_px);
  shaking.Add(Noise(1), Turn(0));
  for (int i = 0; i < 50; ++i)
    EXPECT_FALSE(shaking.Add(Noise(1), Turn(i % 2 == 0 ? 0.001 : -0.001)));
}

TEST(RepeatedImageTest, AtRestAnImageMayComeAgain) {
  RepeatedImage watch(kFocal_px);
  for (int i = 0; i < 200; ++i) {
    EXPECT_FALSE(watch.Add(Noise(1), Step(i % 2 == 0 ? 1e-3 : -1e-3)));
    EXPECT_EQ(watch.is_same(), i > 0);
  }
}

TEST(RepeatedImageTest, TheFirstOnesAfterImagesThatDifferAreNotNeeded) {
  RepeatedImage watch(kFocal_px);
  for (int i = 0; i < 6; ++i)
    EXPECT_FALSE(watch.Add(Noise(static_cast<std::uint64_t>(i)), Turn(0)));
  for (int i = 0; i < 20; ++i)
    EXPECT_EQ(watch.Add(Noise(5), Turn(0)), i < 3) << i;
  EXPECT_FALSE(watch.Add(Noise(6), Turn(0)));
  EXPECT_FALSE(watch.Add(Noise(6), Turn(0))) << "not many have differed";
}

TEST(RepeatedImageTest, ABiasThatIsNotKnownIsNoMotion) {
  RepeatedImage watch(kFocal_px);
  RepeatedImage::Motion motion = Turn(0.004);  // 0.08 rad/s
  motion.rotation_slack = 0.005;
  for (int i = 0; i < 50; ++i)
    EXPECT_FALSE(watch.Add(Noise(1), motion));
}

}  // namespace
}  // namespace facet
