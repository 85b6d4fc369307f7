// SPDX-License-Identifier: BSD-2-Clause
#include "facet/loop/upright_corners.h"

#include <gtest/gtest.h>

#include "facet/geometry/so3.h"
#include "facet/testing/loop/painted_room.h"

namespace facet {
namespace {

using testing::LooksAhead;
using testing::PaintedRoom;
using testing::SmallCamera;

TEST(UprightCornersTest, DistanceCountsBits) {
  const BinaryDescriptor none{}, all{~0ULL, ~0ULL, ~0ULL, ~0ULL}, some{1, 3, 0, 1ULL << 63};
  EXPECT_EQ(HammingDistance(none, none), 0);
  EXPECT_EQ(HammingDistance(none, all), 256);
  EXPECT_EQ(HammingDistance(none, some), 4);
  EXPECT_EQ(HammingDistance(some, all), 252);
}

// The same places, seen by a camera that has turned about its axis.
TEST(UprightCornersTest, DescriptorsStayTheSameWhenTheCameraRolls) {
  const PaintedRoom room(1);
  const CameraModel camera = SmallCamera();
  UprightCorners corners(camera);
  const SE3 T_WC = LooksAhead();
  const SE3 T_rolled(T_WC.q * ExpSO3(Vector3d(0, 0, 0.6)), T_WC.p);
  const cv::Mat picture = room.Picture(camera, T_WC), rolled = room.Picture(camera, T_rolled);
  std::vector<Vector2d> places, places_rolled;
  for (const UprightCorner& corner :
       corners.Detect(picture, T_WC.q.conjugate() * Vector3d::UnitZ())) {
    const Vector3d bearing_W = T_WC.q * *camera.Unproject(corner.px);
    const auto px = camera.Project(T_rolled.q.conjugate() * bearing_W);
    if (!px || !camera.IsInside(*px, 40) || !camera.IsInside(corner.px, 40)) continue;
    places.push_back(corner.px);
    places_rolled.push_back(*px);
  }
  ASSERT_GT(places.size(), 50U);
  const auto here = corners.Describe(picture, T_WC.q.conjugate() * Vector3d::UnitZ(), places);
  const auto there =
      corners.Describe(rolled, T_rolled.q.conjugate() * Vector3d::UnitZ(), places_rolled);
  ASSERT_EQ(here.size(), there.size());
  double same = 0, other = 0;
  for (std::size_t i = 0; i < here.size(); ++i) {
    ASSERT_EQ(here[i].source, there[i].source);
    same += HammingDistance(here[i].descriptor, there[i].descriptor);
    other += HammingDistance(here[i].descriptor, there[(i + 7) % there.size()].descriptor);
  }
  const auto n = static_cast<double>(here.size());
  EXPECT_LT(same / n, 45);
  EXPECT_GT(other / n, 90);
}

TEST(UprightCornersTest, PlacesAtTheBorderHaveNoDescriptor) {
  const CameraModel camera = SmallCamera();
  UprightCorners corners(camera);
  const cv::Mat picture = PaintedRoom(1).Picture(camera, LooksAhead());
  const std::vector<Vector2d> places = {{3, 100}, {180, 120}};
  const auto described = corners.Describe(picture, -Vector3d::UnitY(), places);
  ASSERT_EQ(described.size(), static_cast<std::size_t>(kNumCornerLevels));
  for (const UprightCorner& corner : described)
    EXPECT_EQ(corner.source, 1);
}

TEST(UprightCornersTest, AnEmptyWallHasNone) {
  const CameraModel camera = SmallCamera();
  const cv::Mat grey(camera.height(), camera.width(), CV_8UC1, cv::Scalar(90));
  EXPECT_TRUE(UprightCorners(camera).Detect(grey, -Vector3d::UnitY()).empty());
}

}  // namespace
}  // namespace facet
