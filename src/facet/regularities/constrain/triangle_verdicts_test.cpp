// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/constrain/triangle_verdicts.h"

#include <gtest/gtest.h>

namespace facet {
namespace {

constexpr double kWallAhead_m = 4;  // from the camera at the origin, along x
constexpr double kFloor_m = 1;      // below it

/// A wall and a floor that meet; 2 m of each are known from there on, and 1 m to either side.
class TriangleVerdictsTest : public ::testing::Test {
 protected:
  TriangleVerdictsTest() {
    AddPlane(3, -Vector3d::UnitX(), {kWallAhead_m, 0, 0}, {0, 1, 0}, {0, 0, 1});
    AddPlane(7, Vector3d::UnitZ(), {kWallAhead_m - 1, 0, -kFloor_m}, {0, 1, 0}, {1, 0, 0});
  }

  void AddPlane(
      int id, const Vector3d& n, const Vector3d& p, const Vector3d& a, const Vector3d& b) {
    PlaneCandidate candidate;
    candidate.plane_W = {n, n.dot(p)};
    candidate.centroid_W = p;
    planes_.emplace_back(candidate, Timestamp{});
    TrackedPlane& plane = planes_.back();
    plane.Confirm(PlaneId{id}, Timestamp{});
    plane.estimate.plane_W = candidate.plane_W;
    plane.estimate.anchor_W = p;
    plane.estimate.covariance(9, 9) = 1e-6;
    plane.extent.AddTriangle({Vector3d(p - a - b), p + a - b, p + a + b});
    plane.extent.AddTriangle({Vector3d(p - a - b), p + a + b, p - a + b});
  }

  static Vector3d OnWall(double y, double z, double before_m = 0) {
    return {kWallAhead_m - before_m, y, z};
  }
  static Vector3d OnFloor(double before_wall_m, double y) {
    return {kWallAhead_m - before_wall_m, y, -kFloor_m};
  }

  // Of the first triangle; `more` stands beside it.
  TriangleVerdict Judge(const std::vector<Vector3d>& corners,
                        const std::vector<std::array<int, 3>>& more = {}) const {
    std::vector<FacePoint> points;
    for (const Vector3d& p : corners)
      points.push_back(MakeFacePoint(p, 0.01, {Vector3d::Zero(), 1.5e-3}));
    std::vector<std::array<int, 3>> triangles = {{0, 1, 2}};
    triangles.insert(triangles.end(), more.begin(), more.end());
    return JudgeTriangles(points, triangles, planes_, SE3(), options_)[0];
  }

  std::vector<TrackedPlane> planes_;
  RegularityOptions options_;
};

TEST_F(TriangleVerdictsTest, ATriangleOnAPlaneIsSurface) {
  EXPECT_EQ(Judge({OnWall(0, 0), OnWall(1, 0), OnWall(0, 1)}).plane_id, 3);
  EXPECT_EQ(Judge({OnFloor(1, 0), OnFloor(0.5, 0), OnFloor(1, 0.5)}).plane_id, 7);
  EXPECT_EQ(Judge({OnWall(0, 0), OnWall(1, 0), OnWall(0, 1, 0.03)}).plane_id, 3);
  EXPECT_EQ(Judge({OnWall(0, 0), OnWall(1, 0), OnWall(0, 1, 0.06)}).plane_id, -1);
}

TEST_F(TriangleVerdictsTest, OnlyBesideWhatIsKnownOfThePlane) {
  EXPECT_EQ(Judge({OnWall(1, 0), OnWall(1.5, 0), OnWall(1, 0.5)}).plane_id, 3);
  EXPECT_EQ(Judge({OnWall(3, 0), OnWall(3.5, 0), OnWall(3, 0.5)}).plane_id, -1);
}

TEST_F(TriangleVerdictsTest, ASmallFaceMayStandAcrossThePlane) {
  const double step_m = 0.04;
  const TriangleVerdict standing =
      Judge({OnWall(0, 0), OnWall(0, step_m, step_m), OnWall(0.02, 0, 0.01)});
  EXPECT_EQ(standing.plane_id, -1) << "its normal is not the plane's";
  EXPECT_FALSE(standing.is_bridge);
}

TEST_F(TriangleVerdictsTest, WhatLeadsFromAPlaneThroughFreeSpaceIsABridge) {
  EXPECT_TRUE(Judge({OnWall(0, 0), OnWall(0.2, 0), OnWall(0, 0.2, 0.3)}).is_bridge);
  EXPECT_TRUE(Judge({OnWall(0, 0), OnWall(0.2, 0, 0.3), OnWall(0, 0.2, 0.3)}).is_bridge);
  EXPECT_TRUE(Judge({OnWall(0, 0), OnWall(0.2, 0), OnWall(0, 0.2, -0.3)}).is_bridge) << "behind";
  EXPECT_FALSE(Judge({OnWall(0, 0), OnWall(0.2, 0), OnWall(0, 0.2, 0.055)}).is_bridge);
}

TEST_F(TriangleVerdictsTest, BesideUnknownSurfaceNothingIsABridge) {
  EXPECT_FALSE(Judge({OnWall(3, 0), OnWall(3.2, 0), OnWall(3, 0.2, 0.3)}).is_bridge);
}

TEST_F(TriangleVerdictsTest, ASurfaceThatGoesOnIsNoBridge) {
  // The side of a box on the floor: below its edge on the floor, above another triangle.
  const std::vector<Vector3d> side = {
      OnFloor(1, 0), OnFloor(1, 0.4), Vector3d(kWallAhead_m - 1, 0.2, -kFloor_m + 0.3)};
  EXPECT_TRUE(Judge(side).is_bridge);
  std::vector<Vector3d> more = side;
  more.push_back({kWallAhead_m - 1, 0.4, -kFloor_m + 0.3});
  more.push_back({kWallAhead_m - 1, 0.3, -kFloor_m + 0.6});
  EXPECT_TRUE(Judge(more, {{2, 3, 4}}).is_bridge) << "it has only a corner in common";
  EXPECT_TRUE(Judge(more, {{1, 2, 4}}).is_bridge) << "this one leads from the floor as well";
  more[1].z() += 0.3;
  EXPECT_FALSE(Judge(more, {{1, 2, 4}}).is_bridge);
  more[4].x() -= 0.3;
  EXPECT_TRUE(Judge(more, {{1, 2, 4}}).is_bridge) << "another direction";
}

TEST_F(TriangleVerdictsTest, ATriangleBetweenTwoPlanesMayNotCutTheCornerFarOff) {
  const auto cut = [&](double size_m) {
    return Judge({OnFloor(size_m, 0), OnFloor(size_m, 0.2), OnWall(0.1, -kFloor_m + size_m)});
  };
  EXPECT_FALSE(cut(0.05).is_bridge);
  EXPECT_TRUE(cut(0.2).is_bridge);
}

TEST_F(TriangleVerdictsTest, PlanesThatAreNotSolvedForSayNothing) {
  const std::vector<Vector3d> on = {OnWall(0, 0), OnWall(1, 0), OnWall(0, 1)};
  const std::vector<Vector3d> bridge = {OnWall(0, 0), OnWall(0.2, 0), OnWall(0, 0.2, 0.3)};
  planes_[0].state = PlaneState::kTentative;
  EXPECT_EQ(Judge(on).plane_id, -1);
  EXPECT_FALSE(Judge(bridge).is_bridge);
  planes_.clear();
  EXPECT_EQ(Judge(on).plane_id, -1);
}

}  // namespace
}  // namespace facet
