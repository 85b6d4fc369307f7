// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/planes/plane_membership.h"

#include <cmath>

#include <gtest/gtest.h>

#include "facet/testing/estimator/test_window.h"

namespace facet {
namespace {

constexpr JoinLimits kLimits{0.2, 0.1};
constexpr RobustOptions kRobust{.reprojection_width = 2.0, .plane_sigma_m = 0.01};

struct Scene {
  explicit Scene(std::uint64_t seed) {
    Rng rng(seed);
    testing::TestWindowOptions options;
    options.noise = 0.1;
    test = testing::MakeTestWindow(options, rng);
    landmark = test.window.landmarks().front().id;
  }

  SlidingWindow& window() { return test.window; }

  // A plane that passes `distance` from the first landmark.
  NewPlane PlaneAt(std::int64_t id, double distance) const {
    const Vector3d n = Vector3d(0.3, -0.2, 0.9).normalized();
    return {PlaneId{id}, Plane{n, n.dot(test.points[0]) - distance}, test.points[0]};
  }

  void Apply(const PlaneAssignments& assignments, const JoinLimits& limits = kLimits) {
    FrameGeometry geometry(test.rig);
    geometry.Update(test.window.frames);
    ApplyAssignments(assignments, limits, kRobust, geometry, test.window);
  }

  testing::TestWindow test;
  LandmarkId landmark;
};

TEST(PlaneMembershipTest, LandmarksJoinAndLeave) {
  Scene scene(1);
  PlaneAssignments join;
  join.created = {scene.PlaneAt(7, 0.0)};
  join.joined = {{scene.landmark, PlaneId{7}}, {LandmarkId{999}, PlaneId{7}}};
  scene.Apply(join);
  ASSERT_EQ(scene.window().planes.size(), 1u);
  EXPECT_EQ(CountMembers(scene.window()), std::vector<int>{1});
  scene.Apply(join);  // once is enough
  EXPECT_EQ(scene.window().planes.size(), 1u);
  EXPECT_EQ(CountMembers(scene.window()), std::vector<int>{1});
  PlaneAssignments leave;
  leave.left = {{scene.landmark, PlaneId{7}}};
  scene.Apply(leave);
  EXPECT_EQ(CountMembers(scene.window()), std::vector<int>{0});
}

TEST(PlaneMembershipTest, WhatLandmarksHaveInCommonDoesNotAverageOut) {
  Scene scene(6);
  PlaneAssignments join;
  join.created = {scene.PlaneAt(1, 0.0), scene.PlaneAt(2, 0.0)};
  scene.Apply(join);
  RobustOptions robust;
  robust.plane_sigma_m = 0.02;
  robust.plane_common_sigma_m = 0.005;
  int n = 0;
  for (WindowLandmark& landmark : scene.window().landmarks())
    n += landmark.planes.Add(0) ? 1 : 0;
  ASSERT_GT(n, 20);
  WeighPlanes(robust, scene.window());
  const double row_sigma_m = scene.window().planes[0].row_sigma_m;
  EXPECT_NEAR(row_sigma_m / std::sqrt(n), std::hypot(0.02 / std::sqrt(n), 0.005), 1e-12);
  EXPECT_EQ(scene.window().planes[1].row_sigma_m, 0.02) << "without landmarks";
}

TEST(PlaneMembershipTest, FarOrUncertainLandmarksDoNotJoin) {
  Scene scene(2);
  PlaneAssignments join;
  join.created = {scene.PlaneAt(1, 5.0), scene.PlaneAt(2, 0.0)};
  join.joined = {{scene.landmark, PlaneId{1}}, {scene.landmark, PlaneId{3}}};
  scene.Apply(join);
  EXPECT_EQ(CountMembers(scene.window()), (std::vector<int>{0, 0}));
  join.joined = {{scene.landmark, PlaneId{2}}};
  scene.Apply(join, {1e-9, 0.1});
  EXPECT_EQ(CountMembers(scene.window()), (std::vector<int>{0, 0}));
  scene.Apply(join);
  EXPECT_EQ(CountMembers(scene.window()), (std::vector<int>{0, 1}));
}

TEST(PlaneMembershipTest, OutliersAreDetached) {
  Scene scene(3);
  PlaneAssignments join;
  join.created = {scene.PlaneAt(1, 0.05), scene.PlaneAt(2, 0.0)};
  join.joined = {{scene.landmark, PlaneId{1}}, {scene.landmark, PlaneId{2}}};
  scene.Apply(join);
  ASSERT_EQ(CountMembers(scene.window()), (std::vector<int>{1, 1}));
  FrameGeometry geometry(scene.test.rig);
  geometry.Update(scene.window().frames);
  EXPECT_EQ(DetachOutliers(geometry, kRobust, 4.0, scene.window()), 1);
  EXPECT_EQ(CountMembers(scene.window()), (std::vector<int>{0, 1}));
}

// The looser the row, the less it has drawn the landmark, and the nearer vision alone would put it.
TEST(PlaneMembershipTest, WhatARowHasDrawnIsTakenBack) {
  for (const double row_sigma_m : {1.0, 0.001}) {
    Scene scene(3);
    PlaneAssignments join;
    join.created = {scene.PlaneAt(1, 0.02)};
    join.joined = {{scene.landmark, PlaneId{1}}};
    scene.Apply(join);
    scene.window().planes[0].row_sigma_m = row_sigma_m;
    FrameGeometry geometry(scene.test.rig);
    geometry.Update(scene.window().frames);
    EXPECT_EQ(DetachOutliers(geometry, kRobust, 4.0, scene.window()), row_sigma_m < 0.01 ? 1 : 0);
  }
}

TEST(PlaneMembershipTest, UnsupportedPlanesGoUnlessThePriorKnowsThem) {
  Scene scene(4);
  PlaneAssignments join;
  join.created = {scene.PlaneAt(1, 0.0), scene.PlaneAt(2, 0.0), scene.PlaneAt(3, 0.0)};
  join.joined = {{scene.landmark, PlaneId{3}}};
  scene.Apply(join);
  scene.window().planes[0].Freeze();
  RemoveUnsupportedPlanes(1, scene.window());
  ASSERT_EQ(scene.window().planes.size(), 2u);
  EXPECT_EQ(scene.window().planes[0].id, PlaneId{1});
  EXPECT_EQ(scene.window().planes[1].id, PlaneId{3});
  EXPECT_EQ(CountMembers(scene.window()), (std::vector<int>{0, 1}));
}

TEST(PlaneMembershipTest, OnlySettledPlanesKeepTheRowsOfLeavingLandmarks) {
  Scene scene(5);
  PlaneAssignments join;
  join.created = {scene.PlaneAt(1, 0.0), scene.PlaneAt(2, 0.0)};
  join.joined = {{scene.landmark, PlaneId{1}}, {scene.landmark, PlaneId{2}}};
  scene.Apply(join);
  const Matrix3d well = Vector3d(1e6, 1e6, 1e6).asDiagonal();
  const Matrix3d badly = Vector3d(1e6, 1.0, 1e6).asDiagonal();
  MarkSettledPlanes({well, badly}, {0.01, 0, 0.01}, scene.window());
  EXPECT_TRUE(scene.window().planes[0].settled);
  EXPECT_FALSE(scene.window().planes[1].settled);
  std::vector<char> leaving(scene.window().landmarks().size(), 0);
  CutUnsettledLinks(leaving, scene.window());
  EXPECT_EQ(CountMembers(scene.window()), (std::vector<int>{1, 1}));
  leaving[0] = 1;
  CutUnsettledLinks(leaving, scene.window());
  EXPECT_EQ(CountMembers(scene.window()), (std::vector<int>{1, 0}));
}

PlaneSighting SightingOf(PlaneId plane, const WindowFrame& frame) {
  PlaneSighting sighting{frame.id, plane};
  sighting.sigma_m = 0.01;
  sighting.sigma_rad = {0.01, 0.01};
  return sighting;
}

TEST(PlaneMembershipTest, ASightedPlaneNeedsOneLandmark) {
  Scene scene(7);
  const WindowFrame& frame = scene.window().frames[1];
  WindowFrame unknown;
  unknown.id = FrameId{999};
  PlaneAssignments assignments;
  assignments.created = {scene.PlaneAt(1, 0.0), scene.PlaneAt(2, 0.0), scene.PlaneAt(3, 0.0)};
  assignments.joined = {{scene.landmark, PlaneId{2}}, {scene.landmark, PlaneId{3}}};
  assignments.sighted = {SightingOf(PlaneId{1}, frame),
                         SightingOf(PlaneId{2}, frame),
                         SightingOf(PlaneId{9}, frame),
                         SightingOf(PlaneId{2}, unknown)};
  scene.Apply(assignments);
  EXPECT_EQ(scene.window().sightings.size(), 2u);
  RemoveUnsupportedPlanes(3, scene.window());
  ASSERT_EQ(scene.window().planes.size(), 1u);
  EXPECT_EQ(scene.window().planes[0].id, PlaneId{2});
  EXPECT_EQ(scene.window().sightings.size(), 1u);
  scene.window().RemovePlane(0);
  EXPECT_TRUE(scene.window().sightings.empty());
}

TEST(PlaneMembershipTest, OnlySettledPlanesKeepWhatLeavingFramesHaveSighted) {
  Scene scene(8);
  PlaneAssignments assignments;
  assignments.created = {scene.PlaneAt(1, 0.0), scene.PlaneAt(2, 0.0)};
  const auto& frames = scene.window().frames;
  assignments.sighted = {SightingOf(PlaneId{1}, frames[0]),
                         SightingOf(PlaneId{2}, frames[0]),
                         SightingOf(PlaneId{1}, frames[1])};
  scene.Apply(assignments);
  scene.window().planes[1].settled = true;
  std::vector<char> leaving(frames.size(), 0);
  CutSightings(leaving, scene.window());
  EXPECT_EQ(scene.window().sightings.size(), 3u);
  leaving[0] = 1;
  CutSightings(leaving, scene.window());
  ASSERT_EQ(scene.window().sightings.size(), 2u);
  EXPECT_EQ(scene.window().sightings[0].plane, PlaneId{2});
  EXPECT_EQ(scene.window().sightings[1].plane, PlaneId{1});
}

// At rest every keyframe shows the same image, with the same errors.
TEST(PlaneMembershipTest, WhatIsSightedFromOnePlaceCountsOnce) {
  Scene scene(9);
  PlaneAssignments assignments;
  assignments.created = {scene.PlaneAt(1, 0.0)};
  auto& frames = scene.window().frames;
  assignments.sighted = {SightingOf(PlaneId{1}, frames[0]), SightingOf(PlaneId{1}, frames[1])};
  scene.Apply(assignments);
  scene.window().planes[0].settled = true;
  std::vector<char> leaving(frames.size(), 0);
  leaving[0] = 1;
  frames[1].x.T_WB.p = frames[0].x.T_WB.p + Vector3d(0.5, 0, 0);
  CutSightings(leaving, scene.window());
  EXPECT_EQ(scene.window().sightings.size(), 2u);
  frames[1].x.T_WB = frames[0].x.T_WB;
  CutSightings(leaving, scene.window());
  ASSERT_EQ(scene.window().sightings.size(), 1u);
  EXPECT_EQ(scene.window().sightings[0].frame, frames[1].id);
}

// Both planes have one landmark; it lies 5 cm and 1 m from their anchors.
TEST(PlaneMembershipTest, SmallPlanesSettleByTheirDistanceAtTheLandmarks) {
  Scene scene(6);
  NewPlane small = scene.PlaneAt(1, 0.0), large = scene.PlaneAt(2, 0.0);
  const Vector3d along = small.plane_W.n.cross(Vector3d::UnitX()).normalized();
  small.centroid_W += 0.05 * along;
  large.centroid_W += along;
  PlaneAssignments join;
  join.created = {small, large};
  join.joined = {{scene.landmark, PlaneId{1}}, {scene.landmark, PlaneId{2}}};
  scene.Apply(join);
  ASSERT_EQ(CountMembers(scene.window()), (std::vector<int>{1, 1}));
  const Matrix3d information = Vector3d(1e4, 1e4, 1e6).asDiagonal();  // 0.014 rad, 1 mm
  MarkSettledPlanes({information, information}, {0.005, 0.004, 0.01}, scene.window());
  EXPECT_TRUE(scene.window().planes[0].settled);
  EXPECT_FALSE(scene.window().planes[1].settled);
}

}  // namespace
}  // namespace facet
