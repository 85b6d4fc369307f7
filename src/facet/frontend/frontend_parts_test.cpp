// SPDX-License-Identifier: BSD-2-Clause
// Detector, outlier rejection, keyframe policy, pyramid.
#include <gtest/gtest.h>

#include "facet/frontend/feature_detector.h"
#include "facet/frontend/image_pyramid.h"
#include "facet/frontend/keyframe_policy.h"
#include "facet/frontend/outlier_rejection.h"
#include "facet/geometry/so3.h"
#include "facet/testing/frontend/synthetic_image.h"

namespace facet {
namespace {

using testing::Render;
using testing::WaveTexture;

cv::Mat Textured(int width, int height) {
  return Render(WaveTexture(2), width, height, [](double x, double y) { return Vector2d(x, y); });
}

constexpr double kBorder_px = 8;  // without corners

class DetectorTest : public ::testing::Test {
 protected:
  std::vector<Vector2d> Detect(const cv::Mat& image, std::span<const Vector2d> occupied, int max) {
    pyramid_.Build(image, 1);
    const auto found = detector_.Detect(image, pyramid_.level(0), occupied, max);
    return {found.begin(), found.end()};
  }

  DetectorOptions options_;
  FeatureDetector detector_{options_, KltOptions{}};
  ImagePyramid pyramid_;
};

TEST_F(DetectorTest, SpreadsPointsOverTheImage) {
  const cv::Mat image = Textured(752, 480);
  const std::vector<Vector2d> points = Detect(image, {}, 1000);
  EXPECT_GT(points.size(), 100U);
  int quadrants[4] = {};
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_TRUE(points[i].x() >= kBorder_px && points[i].x() < 752 - kBorder_px);
    EXPECT_TRUE(points[i].y() >= kBorder_px && points[i].y() < 480 - kBorder_px);
    ++quadrants[(points[i].x() > 376 ? 1 : 0) + (points[i].y() > 240 ? 2 : 0)];
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_GE((points[i] - points[j]).norm(), options_.min_distance_px);
    }
  }
  for (const int n : quadrants)
    EXPECT_GT(n, static_cast<int>(points.size()) / 6);
}

TEST_F(DetectorTest, KeepsAwayFromTracks) {
  const cv::Mat image = Textured(752, 480);
  const std::vector<Vector2d> tracks = Detect(image, {}, 60);
  ASSERT_EQ(tracks.size(), 60U);
  for (const Vector2d& p : Detect(image, tracks, 1000)) {
    for (const Vector2d& q : tracks)
      EXPECT_GE((p - q).norm(), options_.min_distance_px - 1);
  }
}

TEST_F(DetectorTest, FindsNothingInFlatOrTinyImages) {
  const cv::Mat flat(480, 752, CV_8UC1, cv::Scalar(90));
  EXPECT_TRUE(Detect(flat, {}, 100).empty());
  const cv::Mat tiny = Textured(20, 18);
  EXPECT_TRUE(Detect(tiny, {}, 100).empty());
  EXPECT_TRUE(Detect(Textured(752, 480), {}, 0).empty());
}

TEST_F(DetectorTest, IgnoresTracksOutsideTheImage) {
  const std::vector<Vector2d> tracks = {{-5, -5}, {1e4, 3}, {300, 900}};
  EXPECT_GT(Detect(Textured(752, 480), tracks, 1000).size(), 100U);
}

std::vector<BearingPair> MakePairs(const Vector3d& t, int num_good, int num_bad, double noise) {
  Rng rng(17);
  std::vector<BearingPair> pairs;
  for (int i = 0; i < num_good + num_bad; ++i) {
    const Vector3d ray = Vector3d(rng.Uniform(-0.7, 0.7), rng.Uniform(-0.5, 0.5), 1).normalized();
    const Vector3d point = rng.Uniform(1.5, 8) * ray;
    Vector3d now = (point - t).normalized() + noise * rng.Normal3();
    if (i >= num_good) now += 0.03 * Vector3d(rng.Normal(), rng.Normal(), 0);
    pairs.push_back({ray, now.normalized()});
  }
  return pairs;
}

TEST(OutlierRejection, FindsMostOutliersAndKeepsInliers) {
  constexpr double kFocal = 458;
  OutlierRejection rejection(OutlierOptions{}, kFocal);
  for (const Vector3d& t :
       {Vector3d(0.1, 0, 0.02), Vector3d(0, 0.02, 0.15), Vector3d(-0.1, 0.1, 0)}) {
    const auto pairs = MakePairs(t, 100, 30, 0.2 / kFocal);
    std::vector<unsigned char> is_outlier;
    ASSERT_EQ(rejection.Find(pairs, is_outlier), OutlierVerdict::kTrusted);
    int wrong = 0, found = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i)
      (i < 100 ? wrong : found) += is_outlier[i];
    EXPECT_LE(wrong, 2) << t.transpose();
    EXPECT_GE(found, 24) << t.transpose();
  }
}

TEST(OutlierRejection, RemovesNothingWithoutParallaxModelOrPoints) {
  OutlierRejection rejection(OutlierOptions{}, 458);
  std::vector<unsigned char> is_outlier;
  const auto still = MakePairs(Vector3d::Zero(), 100, 5, 0.3 / 458);
  EXPECT_EQ(rejection.Find(still, is_outlier), OutlierVerdict::kLowParallax);
  EXPECT_EQ(rejection.Find({}, is_outlier), OutlierVerdict::kFewPoints);
  const auto chaos = MakePairs(Vector3d(0.1, 0, 0), 30, 70, 0.2 / 458);
  EXPECT_EQ(rejection.Find(chaos, is_outlier), OutlierVerdict::kNoModel);
  for (const unsigned char o : is_outlier)
    EXPECT_EQ(o, 0);
}

TEST(OutlierRejection, ToleratesAWrongRotation) {
  OutlierRejection rejection(OutlierOptions{}, 458);
  auto pairs = MakePairs(Vector3d(0.05, 0.02, 0.03), 100, 10, 0.2 / 458);
  const Quaterniond wrong = ExpSO3(Vector3d(0.005, -0.01, 0.02));  // 0.1 rad/s for 0.2 s
  for (BearingPair& pair : pairs)
    pair.now = wrong * pair.now;
  std::vector<unsigned char> is_outlier;
  ASSERT_EQ(rejection.Find(pairs, is_outlier), OutlierVerdict::kTrusted);
  int wrong_count = 0, found = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i)
    (i < 100 ? wrong_count : found) += is_outlier[i];
  EXPECT_LE(wrong_count, 2);
  EXPECT_GE(found, 7);
}

KeyframeReason At(KeyframePolicy& policy, std::int64_t ns, int num_tracked = 100) {
  return policy.Decide(Timestamp{ns}, {num_tracked, num_tracked});
}

TEST(KeyframePolicy, EveryFourthFrameInSpiteOfJitter) {
  KeyframePolicy policy{KeyframeOptions()};
  int last = 0;
  for (int i = 0; i < 100; ++i) {
    const std::int64_t jitter = i % 3 * 128 - 128;
    const KeyframeReason reason = At(policy, 1'000'000'000'000 + i * 50'000'000LL + jitter);
    if (i == 0) {
      EXPECT_EQ(reason, KeyframeReason::kFirst);
      policy.SetKeyframeSize(100);
      continue;
    }
    if (reason == KeyframeReason::kNone) continue;
    EXPECT_EQ(reason, KeyframeReason::kInterval);
    EXPECT_EQ(i - last, 4);
    last = i;
    policy.SetKeyframeSize(100);
  }
  EXPECT_EQ(last, 96);
}

TEST(KeyframePolicy, FewTracksAndClocksThatRunBackwards) {
  KeyframePolicy policy{KeyframeOptions()};
  EXPECT_EQ(At(policy, 0), KeyframeReason::kFirst);
  policy.SetKeyframeSize(100);
  EXPECT_EQ(At(policy, 50'000'000, 71), KeyframeReason::kNone);
  EXPECT_EQ(At(policy, 100'000'000, 69), KeyframeReason::kFewTracks);
  EXPECT_EQ(At(policy, 2'000'000'000), KeyframeReason::kInterval);
  EXPECT_EQ(At(policy, 1'000'000'000), KeyframeReason::kInterval) << "the clock ran backwards";
  EXPECT_STREQ(ToString(KeyframeReason::kFewTracks), "few_tracks");
}

TEST(KeyframePolicy, PointsThatBecameOtherLandmarksAreWorthLess) {
  KeyframeOptions options;
  options.min_tracked_ratio = 0.7;
  options.min_landmark_ratio = 0.3;
  KeyframePolicy policy{options};
  EXPECT_EQ(policy.Decide(Timestamp{0}, {}), KeyframeReason::kFirst);
  policy.SetKeyframeSize(100);
  EXPECT_EQ(policy.Decide(Timestamp{50'000'000}, {90, 31}), KeyframeReason::kNone);
  EXPECT_EQ(policy.Decide(Timestamp{100'000'000}, {90, 29}), KeyframeReason::kFewTracks);
}

TEST(ImagePyramid, HalvesUntilTooSmallAndKeepsItsBuffers) {
  const cv::Mat image = Textured(101, 67);
  ImagePyramid pyramid;
  pyramid.Build(image, 5);
  ASSERT_EQ(pyramid.num_levels(), 3);
  EXPECT_EQ(pyramid.level(0).data, image.data) << "the image itself is not copied";
  EXPECT_EQ(pyramid.level(1).width, 51);
  EXPECT_EQ(pyramid.level(2).height, 17);
  const std::uint8_t* const buffer = pyramid.level(1).data;
  const cv::Mat other = Textured(101, 67);
  pyramid.Build(other, 5);
  EXPECT_EQ(pyramid.level(1).data, buffer);
  pyramid.Clear();
  EXPECT_TRUE(pyramid.empty());
}

}  // namespace
}  // namespace facet
