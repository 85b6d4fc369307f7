// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/detect/region_growing.h"

#include <cmath>

#include <gtest/gtest.h>

#include "facet/geometry/angles.h"
#include "facet/testing/regularities/test_scene.h"

namespace facet {
namespace {

using testing::AllOf;
using testing::MakeFaces;
using testing::MakeFloor;
using testing::Patch;
using testing::TestView;
using testing::Turned;

TestView ViewFromAbove() {
  TestView view;
  view.camera_W = {0, 0, 4};
  view.sigma_depth_m = 0.005;
  return view;
}

TEST(RegionGrowingTest, ARoofHasTwoSidesLargestFirst) {
  const Patch left = Turned(MakeFloor({-1.2, 0, 1}, 2, 3), Vector3d::UnitY(), -40 * kDegree);
  const Patch right = Turned(MakeFloor({1, 0, 1}, 1.5, 3), Vector3d::UnitY(), 40 * kDegree);
  const SurfaceFaces faces = MakeFaces({right, left}, ViewFromAbove());
  const auto regions = GrowRegions(faces, AllOf(faces), 1.0);
  ASSERT_EQ(regions.size(), 2u);
  EXPECT_GT(std::abs(regions[0].n.dot(left.ToPlane().n)), std::cos(2 * kDegree));
  EXPECT_NEAR(regions[0].SignedDistance(left.centre_W), 0, 0.02);
  EXPECT_GT(std::abs(regions[1].n.dot(right.ToPlane().n)), std::cos(2 * kDegree));
}

TEST(RegionGrowingTest, OnlyFacesThatShareASideAreNeighbours) {
  // Two halves of one surface without a common vertex, each of half the area.
  const SurfaceFaces faces =
      MakeFaces({MakeFloor({-1, 0, 1}, 1, 1), MakeFloor({1, 0, 1}, 1, 1)}, ViewFromAbove());
  EXPECT_EQ(GrowRegions(faces, AllOf(faces), 0.7).size(), 2u);
  EXPECT_TRUE(GrowRegions(faces, AllOf(faces), 1.5).empty());
  // Triangles that meet in a vertex only.
  SurfaceFaces fan;
  for (const auto& p : {Vector3d(0, 0, 0),
                        Vector3d(1, 0, 0),
                        Vector3d(1, 1, 0),
                        Vector3d(-1, 0, 0),
                        Vector3d(-1, -1, 0)}) {
    FacePoint point;
    point.p_W = p;
    fan.points.push_back(point);
  }
  for (const std::array<int, 3>& corners : {std::array{0, 1, 2}, std::array{0, 3, 4}}) {
    SurfaceFace face;
    face.corners = corners;
    face.area_m2 = face.search_area_m2 = 0.5;
    for (const int corner : corners)
      face.centre_W += fan.points[corner].p_W / 3;
    fan.faces.push_back(face);
  }
  EXPECT_EQ(GrowRegions(fan, AllOf(fan), 0.4).size(), 2u);
}

TEST(RegionGrowingTest, ThreeFacesOnOneSideAreAllNeighbours) {
  SurfaceFaces fan;
  for (const auto& p : {Vector3d(0, 0, 0),
                        Vector3d(1, 0, 0),
                        Vector3d(0, 1, 0),
                        Vector3d(1, -1, 0),
                        Vector3d(0.5, 0.8, 0)}) {
    FacePoint point;
    point.p_W = p;
    fan.points.push_back(point);
  }
  for (const int third : {2, 3, 4}) {
    SurfaceFace face;
    face.corners = {1, 0, third};
    face.area_m2 = face.search_area_m2 = 0.5;
    face.centre_W = (fan.points[0].p_W + fan.points[1].p_W + fan.points[third].p_W) / 3;
    fan.faces.push_back(face);
  }
  EXPECT_EQ(GrowRegions(fan, AllOf(fan), 1.4).size(), 1u);
}

TEST(RegionGrowingTest, LeavesFacesOutsideThePoolAlone) {
  const SurfaceFaces faces = MakeFaces({MakeFloor({0, 0, 1}, 2, 2)}, ViewFromAbove());
  std::vector<int> pool = AllOf(faces);
  pool.resize(pool.size() / 2);
  EXPECT_EQ(GrowRegions(faces, pool, 1.5).size(), 1u);
  EXPECT_TRUE(GrowRegions(faces, pool, 2.5).empty());
  EXPECT_TRUE(GrowRegions(faces, {}, 0).empty());
}

}  // namespace
}  // namespace facet
