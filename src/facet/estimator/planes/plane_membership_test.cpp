// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/planes/plane_membership.h"

#include <cmath>

#include <gtest/gtest.h>

#include "facet/testing/estimator/plane_scene.h"

namespace facet {
namespace {

using Scene = testing::PlaneScene;

TEST(PlaneMembershipTest, LandmarksJoinAndLeave) {
  Scene scene(1);
  PlaneAssignments join;
  join.created = {scene.PlaneAt(7, 0.0)};
  join.attached = {{scene.landmark, PlaneId{7}}, {LandmarkId{999}, PlaneId{7}}};
  scene.Apply(join);
  ASSERT_EQ(scene.window().planes.size(), 1u);
  EXPECT_EQ(scene.window().CountPlaneLandmarks(), std::vector<int>{1});
  scene.Apply(join);  // once is enough
  EXPECT_EQ(scene.window().planes.size(), 1u);
  EXPECT_EQ(scene.window().CountPlaneLandmarks(), std::vector<int>{1});
  PlaneAssignments leave;
  leave.detached = {{scene.landmark, PlaneId{7}}};
  scene.Apply(leave);
  EXPECT_EQ(scene.window().CountPlaneLandmarks(), std::vector<int>{0});
}

TEST(PlaneMembershipTest, WhatLandmarksHaveInCommonDoesNotAverageOut) {
  Scene scene(6);
  PlaneAssignments join;
  join.created = {scene.PlaneAt(1, 0.0), scene.PlaneAt(2, 0.0)};
  scene.Apply(join);
  scene.noise.plane_sigma_m = 0.02;
  scene.noise.plane_common_sigma_m = 0.005;
  int n = 0;
  for (WindowLandmark& landmark : scene.window().landmarks())
    n += landmark.planes.Add(0) ? 1 : 0;
  ASSERT_GT(n, 20);
  WeighPlanes(scene.noise, scene.window());
  const double row_sigma_m = scene.window().planes[0].row_sigma_m;
  EXPECT_NEAR(row_sigma_m / std::sqrt(n), std::hypot(0.02 / std::sqrt(n), 0.005), 1e-12);
  EXPECT_EQ(scene.window().planes[1].row_sigma_m, 0.02) << "without landmarks";
}

TEST(PlaneMembershipTest, LandmarksOfUnevenSurfacesCountLess) {
  Scene scene(1);
  PlaneAssignments told;
  told.created = {scene.PlaneAt(7, 0.0)};
  told.unevenness = {{PlaneId{7}, 0.03}, {PlaneId{99}, 0.1}};
  scene.Apply(told);
  EXPECT_EQ(scene.window().planes[0].unevenness_m, 0.03);
  double n = 0;
  for (WindowLandmark& landmark : scene.window().landmarks())
    n += landmark.planes.Add(0) ? 1 : 0;
  WeighPlanes(scene.noise, scene.window());
  const double common_m = std::hypot(scene.noise.plane_common_sigma_m, 0.3 * 0.03);
  EXPECT_NEAR(scene.window().planes[0].row_sigma_m,
              std::hypot(scene.noise.plane_sigma_m, 0.03, std::sqrt(n) * common_m),
              1e-12);
}

TEST(PlaneMembershipTest, FarOrUncertainLandmarksDoNotJoin) {
  Scene scene(2);
  PlaneAssignments join;
  join.created = {scene.PlaneAt(1, 5.0), scene.PlaneAt(2, 0.0)};
  join.attached = {{scene.landmark, PlaneId{1}}, {scene.landmark, PlaneId{3}}};
  scene.Apply(join);
  EXPECT_EQ(scene.window().CountPlaneLandmarks(), (std::vector<int>{0, 0}));
  join.attached = {{scene.landmark, PlaneId{2}}};
  const double max_sigma_m = scene.limits.max_sigma_m;
  scene.limits.max_sigma_m = 1e-9;
  scene.Apply(join);
  EXPECT_EQ(scene.window().CountPlaneLandmarks(), (std::vector<int>{0, 0}));
  scene.limits.max_sigma_m = max_sigma_m;
  scene.Apply(join);
  EXPECT_EQ(scene.window().CountPlaneLandmarks(), (std::vector<int>{0, 1}));
}

// Far away more may stand out of a surface, and landmarks are known less.
TEST(PlaneMembershipTest, FarLandmarksJoinWithLargerSigmas) {
  Scene scene(2);
  PlaneAssignments join;
  join.created = {scene.PlaneAt(1, 0.0)};
  join.attached = {{scene.landmark, PlaneId{1}, 0, 1}};
  const double max_sigma_m = scene.limits.max_sigma_m;
  scene.limits.max_sigma_m = 1e-9;
  scene.Apply(join);
  EXPECT_EQ(scene.window().CountPlaneLandmarks(), std::vector<int>{0});
  join.attached[0].length_scale = max_sigma_m / 1e-9;
  scene.Apply(join);
  EXPECT_EQ(scene.window().CountPlaneLandmarks(), std::vector<int>{1});
  scene.window().Find(scene.landmark)->planes.Remove(0);
  scene.limits.max_sigma_m = max_sigma_m;
  join.attached[0].length_scale = 3;
  scene.Apply(join);
  ASSERT_EQ(scene.window().CountPlaneLandmarks(), std::vector<int>{1});
  EXPECT_EQ(scene.window().Find(scene.landmark)->planes.row_scale(0), 3);
}

TEST(PlaneMembershipTest, OutliersAreDetached) {
  Scene scene(3);
  PlaneAssignments join;
  join.created = {scene.PlaneAt(1, 0.05), scene.PlaneAt(2, 0.0)};
  join.attached = {{scene.landmark, PlaneId{1}}, {scene.landmark, PlaneId{2}}};
  scene.Apply(join);
  ASSERT_EQ(scene.window().CountPlaneLandmarks(), (std::vector<int>{1, 1}));
  EXPECT_EQ(DetachOutliers(scene.Geometry(), scene.noise, 4.0, scene.window()), 1);
  EXPECT_EQ(scene.window().CountPlaneLandmarks(), (std::vector<int>{0, 1}));
}

// The looser the row, the less it has drawn the landmark, and the nearer vision alone would put it.
TEST(PlaneMembershipTest, WhatARowHasDrawnIsTakenBack) {
  for (const double row_sigma_m : {1.0, 0.001}) {
    Scene scene(3);
    PlaneAssignments join;
    join.created = {scene.PlaneAt(1, 0.02)};
    join.attached = {{scene.landmark, PlaneId{1}}};
    scene.Apply(join);
    scene.window().planes[0].row_sigma_m = row_sigma_m;
    EXPECT_EQ(DetachOutliers(scene.Geometry(), scene.noise, 4.0, scene.window()),
              row_sigma_m < 0.01 ? 1 : 0);
  }
}

TEST(PlaneMembershipTest, UnsupportedPlanesGoUnlessThePriorKnowsThem) {
  Scene scene(4);
  PlaneAssignments join;
  join.created = {scene.PlaneAt(1, 0.0), scene.PlaneAt(2, 0.0), scene.PlaneAt(3, 0.0)};
  join.attached = {{scene.landmark, PlaneId{3}}};
  scene.Apply(join);
  scene.window().planes[0].Freeze();
  RemoveSparsePlanes(1, scene.window());
  ASSERT_EQ(scene.window().planes.size(), 2u);
  EXPECT_EQ(scene.window().planes[0].id, PlaneId{1});
  EXPECT_EQ(scene.window().planes[1].id, PlaneId{3});
  EXPECT_EQ(scene.window().CountPlaneLandmarks(), (std::vector<int>{0, 1}));
}

TEST(PlaneMembershipTest, AMeasuredPlaneNeedsOneLandmark) {
  Scene scene(7);
  const WindowFrame& frame = scene.window().frames[1];
  WindowFrame unknown;
  unknown.id = FrameId{999};
  PlaneAssignments assignments;
  assignments.created = {scene.PlaneAt(1, 0.0), scene.PlaneAt(2, 0.0), scene.PlaneAt(3, 0.0)};
  assignments.attached = {{scene.landmark, PlaneId{2}}, {scene.landmark, PlaneId{3}}};
  assignments.measurements = {testing::MeasurementOf(PlaneId{1}, frame),
                              testing::MeasurementOf(PlaneId{2}, frame),
                              testing::MeasurementOf(PlaneId{9}, frame),
                              testing::MeasurementOf(PlaneId{2}, unknown)};
  scene.Apply(assignments);
  EXPECT_EQ(scene.window().measurements.size(), 2u);
  RemoveSparsePlanes(3, scene.window());
  ASSERT_EQ(scene.window().planes.size(), 1u);
  EXPECT_EQ(scene.window().planes[0].id, PlaneId{2});
  EXPECT_EQ(scene.window().measurements.size(), 1u);
  scene.window().RemovePlane(0);
  EXPECT_TRUE(scene.window().measurements.empty());
}

TEST(PlaneMembershipTest, LandmarksConvertAndConvertBack) {
  Rng rng(3);
  SlidingWindow window = testing::MakeTestWindow({}, rng).window;
  const LandmarkId id = window.landmarks()[3].id;
  PlaneAssignments to, back;
  to.projected = {id, LandmarkId{99999}};
  back.unprojected = {id, LandmarkId{99999}};
  ApplyProjections(to, true, window);
  EXPECT_TRUE(window.Find(id)->is_projection);
  EXPECT_FALSE(window.landmarks()[0].is_projection);
  ApplyProjections(back, false, window);  // the paper never converts back
  EXPECT_TRUE(window.Find(id)->is_projection);
  ApplyProjections(back, true, window);
  EXPECT_FALSE(window.Find(id)->is_projection);
}

}  // namespace
}  // namespace facet
