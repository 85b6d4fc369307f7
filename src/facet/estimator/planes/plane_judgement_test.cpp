// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/planes/plane_judgement.h"

#include <gtest/gtest.h>

#include "facet/geometry/angles.h"
#include "facet/testing/estimator/plane_scene.h"

namespace facet {
namespace {

using Scene = testing::PlaneScene;

PlaneOptions Limits(double normal_rad, double rim_m, double offset_m) {
  PlaneOptions options;
  options.settled_normal_deg = normal_rad / kDegree;
  options.settled_rim_m = rim_m;
  options.settled_offset_m = offset_m;
  return options;
}

TEST(PlaneJudgementTest, OnlySettledPlanesKeepTheRowsOfLeavingLandmarks) {
  Scene scene(5);
  PlaneAssignments join;
  join.created = {scene.PlaneAt(1, 0.0), scene.PlaneAt(2, 0.0)};
  join.joined = {{scene.landmark, PlaneId{1}}, {scene.landmark, PlaneId{2}}};
  scene.Apply(join);
  const Matrix3d well = Vector3d(1e6, 1e6, 1e6).asDiagonal();
  const Matrix3d badly = Vector3d(1e6, 1.0, 1e6).asDiagonal();
  MarkSettledPlanes({well, badly}, Limits(0.01, 0, 0.01), scene.window());
  EXPECT_TRUE(scene.window().planes[0].settled);
  EXPECT_FALSE(scene.window().planes[1].settled);
  std::vector<char> leaving(scene.window().landmarks().size(), 0);
  CutUnsettledLinks(leaving, scene.window());
  EXPECT_EQ(scene.window().CountMembers(), (std::vector<int>{1, 1}));
  leaving[0] = 1;
  CutUnsettledLinks(leaving, scene.window());
  EXPECT_EQ(scene.window().CountMembers(), (std::vector<int>{1, 0}));
}

// Both planes have one landmark; it lies 5 cm and 1 m from their anchors.
TEST(PlaneJudgementTest, SmallPlanesSettleByTheirDistanceAtTheLandmarks) {
  Scene scene(6);
  NewPlane small = scene.PlaneAt(1, 0.0), large = scene.PlaneAt(2, 0.0);
  const Vector3d along = small.plane_W.n.cross(Vector3d::UnitX()).normalized();
  small.centroid_W += 0.05 * along;
  large.centroid_W += along;
  PlaneAssignments join;
  join.created = {small, large};
  join.joined = {{scene.landmark, PlaneId{1}}, {scene.landmark, PlaneId{2}}};
  scene.Apply(join);
  ASSERT_EQ(scene.window().CountMembers(), (std::vector<int>{1, 1}));
  const Matrix3d information = Vector3d(1e4, 1e4, 1e6).asDiagonal();  // 0.014 rad, 1 mm
  MarkSettledPlanes({information, information}, Limits(0.005, 0.004, 0.01), scene.window());
  EXPECT_TRUE(scene.window().planes[0].settled);
  EXPECT_FALSE(scene.window().planes[1].settled);
}

TEST(PlaneJudgementTest, ViolatedRelationsAreDropped) {
  using enum PlaneRelationKind;
  Scene scene(7);
  PlaneAssignments assignments;
  assignments.created = {scene.PlaneAt(4, 0.0), scene.PlaneAt(7, 0.0)};
  assignments.related = {{kParallel, PlaneId{4}, PlaneId{7}}, {kVertical, PlaneId{4}}};
  scene.Apply(assignments);
  ASSERT_EQ(scene.window().relations.size(), 2u);
  scene.window().planes[0].n = Vector3d(0.6, 0, 0.8);
  scene.window().planes[1].n = Vector3d(-0.6, 0.001, -0.8).normalized();
  EXPECT_EQ(DropViolatedRelations(scene.noise.relations, 4.0, scene.window()), 1);
  ASSERT_EQ(scene.window().relations.size(), 1u);
  EXPECT_EQ(scene.window().relations[0].relation.kind, kParallel);
}

TEST(PlaneJudgementTest, OnlySettledPlanesKeepWhatLeavingFramesHaveSighted) {
  Scene scene(8);
  PlaneAssignments assignments;
  assignments.created = {scene.PlaneAt(1, 0.0), scene.PlaneAt(2, 0.0)};
  const auto& frames = scene.window().frames;
  assignments.sighted = {testing::SightingOf(PlaneId{1}, frames[0]),
                         testing::SightingOf(PlaneId{2}, frames[0]),
                         testing::SightingOf(PlaneId{1}, frames[1])};
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
TEST(PlaneJudgementTest, WhatIsSightedFromOnePlaceCountsOnce) {
  Scene scene(9);
  PlaneAssignments assignments;
  assignments.created = {scene.PlaneAt(1, 0.0)};
  auto& frames = scene.window().frames;
  assignments.sighted = {testing::SightingOf(PlaneId{1}, frames[0]),
                         testing::SightingOf(PlaneId{1}, frames[1])};
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

}  // namespace
}  // namespace facet
