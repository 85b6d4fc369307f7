// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/planes/plane_judgement.h"

#include <gtest/gtest.h>

#include "facet/geometry/angles.h"
#include "facet/testing/estimator/plane_scene.h"

namespace facet {
namespace {

using Scene = testing::PlaneScene;

PersistenceLimits Limits(double normal_rad, double boundary_m, double offset_m) {
  return {normal_rad / kDegree, boundary_m, offset_m};
}

TEST(PlaneJudgementTest, OnlyPersistentPlanesKeepTheRowsOfLeavingLandmarks) {
  Scene scene(5);
  PlaneAssignments join;
  join.created = {scene.PlaneAt(1, 0.0), scene.PlaneAt(2, 0.0)};
  join.attached = {{scene.landmark, PlaneId{1}}, {scene.landmark, PlaneId{2}}};
  scene.Apply(join);
  const Matrix3d well = Vector3d(1e6, 1e6, 1e6).asDiagonal();
  const Matrix3d badly = Vector3d(1e6, 1.0, 1e6).asDiagonal();
  MarkPersistentPlanes({well, badly}, Limits(0.01, 0, 0.01), scene.window());
  EXPECT_TRUE(scene.window().planes[0].persistent);
  EXPECT_FALSE(scene.window().planes[1].persistent);
  std::vector<char> leaving(scene.window().landmarks().size(), 0);
  CutNonPersistentLinks(leaving, scene.window());
  EXPECT_EQ(scene.window().CountPlaneLandmarks(), (std::vector<int>{1, 1}));
  leaving[0] = 1;
  CutNonPersistentLinks(leaving, scene.window());
  EXPECT_EQ(scene.window().CountPlaneLandmarks(), (std::vector<int>{1, 0}));
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
  join.attached = {{scene.landmark, PlaneId{1}}, {scene.landmark, PlaneId{2}}};
  scene.Apply(join);
  ASSERT_EQ(scene.window().CountPlaneLandmarks(), (std::vector<int>{1, 1}));
  const Matrix3d information = Vector3d(1e4, 1e4, 1e6).asDiagonal();  // 0.014 rad, 1 mm
  MarkPersistentPlanes({information, information}, Limits(0.005, 0.004, 0.01), scene.window());
  EXPECT_TRUE(scene.window().planes[0].persistent);
  EXPECT_FALSE(scene.window().planes[1].persistent);
}

TEST(PlaneJudgementTest, ViolatedRelationsAreDropped) {
  using enum PlaneRelationKind;
  Scene scene(7);
  PlaneAssignments assignments;
  assignments.created = {scene.PlaneAt(4, 0.0), scene.PlaneAt(7, 0.0)};
  assignments.relations = {{kParallel, PlaneId{4}, PlaneId{7}}, {kVertical, PlaneId{4}}};
  scene.Apply(assignments);
  ASSERT_EQ(scene.window().relations.size(), 2u);
  scene.window().planes[0].n = Vector3d(0.6, 0, 0.8);
  scene.window().planes[1].n = Vector3d(-0.6, 0.001, -0.8).normalized();
  EXPECT_EQ(DropViolatedRelations(scene.noise.relations, 4.0, scene.window()), 1);
  ASSERT_EQ(scene.window().relations.size(), 1u);
  EXPECT_EQ(scene.window().relations[0].relation.kind, kParallel);
}

TEST(PlaneJudgementTest, OnlyPersistentPlanesKeepWhatLeavingFramesHaveMeasured) {
  Scene scene(8);
  PlaneAssignments assignments;
  assignments.created = {scene.PlaneAt(1, 0.0), scene.PlaneAt(2, 0.0)};
  const auto& frames = scene.window().frames;
  assignments.measurements = {testing::MeasurementOf(PlaneId{1}, frames[0]),
                              testing::MeasurementOf(PlaneId{2}, frames[0]),
                              testing::MeasurementOf(PlaneId{1}, frames[1])};
  scene.Apply(assignments);
  scene.window().planes[1].persistent = true;
  std::vector<char> leaving(frames.size(), 0);
  CutMeasurements(leaving, scene.window());
  EXPECT_EQ(scene.window().measurements.size(), 3u);
  leaving[0] = 1;
  CutMeasurements(leaving, scene.window());
  ASSERT_EQ(scene.window().measurements.size(), 2u);
  EXPECT_EQ(scene.window().measurements[0].plane, PlaneId{2});
  EXPECT_EQ(scene.window().measurements[1].plane, PlaneId{1});
}

// At rest every keyframe shows the same image, with the same errors.
TEST(PlaneJudgementTest, WhatIsMeasuredFromOnePlaceCountsOnce) {
  Scene scene(9);
  PlaneAssignments assignments;
  assignments.created = {scene.PlaneAt(1, 0.0)};
  auto& frames = scene.window().frames;
  assignments.measurements = {testing::MeasurementOf(PlaneId{1}, frames[0]),
                              testing::MeasurementOf(PlaneId{1}, frames[1])};
  scene.Apply(assignments);
  scene.window().planes[0].persistent = true;
  std::vector<char> leaving(frames.size(), 0);
  leaving[0] = 1;
  frames[1].x.T_WB.p = frames[0].x.T_WB.p + Vector3d(0.5, 0, 0);
  CutMeasurements(leaving, scene.window());
  EXPECT_EQ(scene.window().measurements.size(), 2u);
  frames[1].x.T_WB = frames[0].x.T_WB;
  CutMeasurements(leaving, scene.window());
  ASSERT_EQ(scene.window().measurements.size(), 1u);
  EXPECT_EQ(scene.window().measurements[0].frame, frames[1].id);
}

}  // namespace
}  // namespace facet
