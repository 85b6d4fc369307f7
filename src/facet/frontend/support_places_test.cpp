// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/support_places.h"

#include <set>

#include <gtest/gtest.h>

#include "facet/base/random.h"

namespace facet {
namespace {

cv::Mat RandomImage(int width, int height) {
  Rng rng(1);
  cv::Mat image(height, width, CV_8UC1);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x)
      image.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(rng.Index(256));
  }
  return image;
}

/// Four features that span the image; the inverse distance grows along x.
struct Corners {
  std::vector<FeatureObservation> features;
  std::vector<double> inverse_distances;

  Corners() {
    for (const Vector2d& px :
         {Vector2d(1, 1), Vector2d(318, 1), Vector2d(1, 238), Vector2d(318, 238)}) {
      FeatureObservation feature;
      feature.landmark = LandmarkId{static_cast<std::int64_t>(features.size())};
      feature.px_left = px;
      features.push_back(feature);
      inverse_distances.push_back(0.2 + 0.001 * px.x());
    }
  }
};

TEST(SupportPlaces, PredictsTheDepthOfThePlaneBetweenTheFeatures) {
  SupportPlaces places{SupportPointOptions()};
  const Corners corners;
  const auto& queries =
      places.Choose(RandomImage(320, 240), corners.features, corners.inverse_distances);
  ASSERT_GT(queries.size(), 30u);
  for (const DepthQuery& query : queries) {
    EXPECT_EQ(query.num_depths, 3) << "the corners differ much";
    EXPECT_NEAR(query.inverse_distances[0], 0.2 + 0.001 * query.px.x(), 1e-9);
    EXPECT_NEAR(query.inverse_distances[1], 0.518, 1e-9);
    EXPECT_NEAR(query.inverse_distances[2], 0.201, 1e-9);
  }
}

TEST(SupportPlaces, CellsTakeTurnsAndThoseWithFeaturesHaveNone) {
  SupportPointOptions options;
  options.cell_px = 20;
  SupportPlaces places(options);
  const Corners corners;
  const cv::Mat image = RandomImage(320, 240);
  std::set<std::pair<int, int>> cells;
  for (int turn = 0; turn < 2; ++turn) {
    for (const DepthQuery& query :
         places.Choose(image, corners.features, corners.inverse_distances)) {
      const std::pair cell(static_cast<int>(query.px.x()) / 20,
                           static_cast<int>(query.px.y()) / 20);
      EXPECT_TRUE(cells.insert(cell).second) << "twice in one cell";
      EXPECT_FALSE(cell == std::pair(0, 0) || cell == std::pair(15, 11));
    }
  }
  EXPECT_EQ(cells.size(), 16u * 12u - 4u);
}

TEST(SupportPlaces, OutsideTheHullTheNearestFeaturesSayHowFar) {
  SupportPlaces places{SupportPointOptions()};
  Corners corners;  // a square in the middle of the image, near on its left side
  for (FeatureObservation& feature : corners.features)
    feature.px_left = Vector2d(160, 120) + 0.3 * (feature.px_left - Vector2d(160, 120));
  const auto& queries =
      places.Choose(RandomImage(320, 240), corners.features, corners.inverse_distances);
  int num_outside = 0;
  for (const DepthQuery& query : queries) {
    if ((query.px - Vector2d(160, 120)).cwiseAbs().maxCoeff() < 60) continue;
    ++num_outside;
    ASSERT_EQ(query.num_depths, 3);
    EXPECT_NEAR(query.inverse_distances[0], query.px.x() < 160 ? 0.201 : 0.518, 1e-9);
  }
  EXPECT_GT(num_outside, 40);
}

TEST(SupportPlaces, NothingWithoutContrastOrDepth) {
  SupportPlaces places{SupportPointOptions()};
  const Corners corners;
  const cv::Mat grey(240, 320, CV_8UC1, cv::Scalar(90));
  EXPECT_TRUE(places.Choose(grey, corners.features, corners.inverse_distances).empty());
  const std::vector<double> unknown(4, 0.0);
  EXPECT_TRUE(places.Choose(RandomImage(320, 240), corners.features, unknown).empty());
  EXPECT_TRUE(places.Choose(RandomImage(320, 240), {}, {}).empty());
  const cv::Mat tiny(5, 5, CV_8UC1, cv::Scalar(90));
  EXPECT_TRUE(places.Choose(tiny, {}, {}).empty());
}

}  // namespace
}  // namespace facet
