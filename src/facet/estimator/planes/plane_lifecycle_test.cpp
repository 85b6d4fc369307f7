// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/planes/plane_lifecycle.h"

#include <gtest/gtest.h>

#include "facet/testing/estimator/plane_scene.h"

namespace facet {
namespace {

class PlaneLifecycleTest : public ::testing::Test {
 protected:
  PlaneLifecycleTest() : scene_(1) { options_.planes.min_landmarks = 1; }

  SlidingWindow& window() { return scene_.window(); }
  void TakeEffect(PlaneLifecycle& life) {
    life.TakeEffect(scene_.noise, scene_.Geometry(), window());
  }
  // Planes through the first landmark, which lies on each of them (there is room for three).
  void AddPlanes(PlaneLifecycle& life, const std::vector<std::int64_t>& ids) {
    PlaneAssignments assignments;
    for (const std::int64_t id : ids) {
      assignments.created.push_back(scene_.PlaneAt(id, 0.0));
      assignments.attached.push_back({scene_.landmark, PlaneId{id}});
    }
    life.Announce(assignments);
    TakeEffect(life);
  }
  std::vector<std::int64_t> Ids() {
    std::vector<std::int64_t> ids;
    for (const WindowPlane& plane : window().planes)
      ids.push_back(plane.id.value);
    return ids;
  }
  // All planes are equally well known.
  void Judge(PlaneLifecycle& life) {
    const std::size_t n = window().planes.size();
    life.Judge(std::vector<Matrix3d>(n, 1e6 * Matrix3d::Identity()),
               std::vector<Matrix<9, 9>>(n, Matrix<9, 9>::Identity()),
               scene_.noise,
               window());
  }

  testing::PlaneScene scene_;
  EstimatorOptions options_;
};

TEST_F(PlaneLifecycleTest, AnnouncementsAddUpAndTakeEffectOnce) {
  PlaneLifecycle life(options_);
  PlaneAssignments create, join;
  create.created = {scene_.PlaneAt(7, 0.0)};
  join.attached = {{scene_.landmark, PlaneId{7}}};
  life.Announce(create);
  life.Announce(join);
  EXPECT_TRUE(window().planes.empty()) << "they wait for the next keyframe";
  TakeEffect(life);
  EXPECT_EQ(window().CountPlaneLandmarks(), std::vector<int>{1});
  EXPECT_EQ(window().planes[0].row_sigma_m,
            std::hypot(scene_.noise.plane_sigma_m, scene_.noise.plane_common_sigma_m));
  window().RemovePlane(0);
  TakeEffect(life);
  EXPECT_TRUE(window().planes.empty());
}

TEST_F(PlaneLifecycleTest, APlaneWithTooLittleSupportGoesAgain) {
  options_.planes.min_landmarks = 2;
  PlaneLifecycle life(options_);
  AddPlanes(life, {7});
  EXPECT_TRUE(window().planes.empty());
}

TEST_F(PlaneLifecycleTest, WhatIsEndedGoesAtOnceUnlessThePriorKnowsIt) {
  PlaneLifecycle life(options_);
  AddPlanes(life, {1, 2, 3});
  window().planes[1].Freeze();
  PlaneAssignments end;
  end.retired = {PlaneId{1}, PlaneId{2}, PlaneId{9}};
  life.Announce(end);
  life.RemoveRetired(window());
  EXPECT_EQ(Ids(), (std::vector<std::int64_t>{2, 3}));
  MarginalizationPlan plan(window());
  life.RetireIn(window(), plan);
  EXPECT_EQ(plan.drop_plane, (std::vector<char>{1, 0}));
  MarginalizationPlan later(window());
  life.RetireIn(window(), later);
  EXPECT_TRUE(later.IsEmpty());
}

TEST_F(PlaneLifecycleTest, OfTooManyPlanesTheLeastKnownAreEnded) {
  options_.planes.max_planes = 2;
  PlaneLifecycle life(options_);
  AddPlanes(life, {1, 2, 3});
  Judge(life);
  EXPECT_EQ(Ids().size(), 3u);
  life.RemoveRetired(window());
  EXPECT_EQ(Ids().size(), 2u);
}

TEST_F(PlaneLifecycleTest, JudgingSettlesPlanesAndKeepsTheirCovariances) {
  PlaneLifecycle life(options_);
  AddPlanes(life, {1, 2});
  Judge(life);
  ASSERT_EQ(life.covariances().size(), 2u);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_TRUE(window().planes[k].persistent);
    EXPECT_EQ(life.covariances()[k].first, window().planes[k].id);
    // A unit covariance of two tangent directions is one across the normal.
    const Matrix<10, 10>& covariance = life.covariances()[k].second;
    const Vector3d& n = window().planes[k].n;
    const Matrix3d across = Matrix3d::Identity() - n * n.transpose();
    EXPECT_LT((covariance.block<3, 3>(6, 6) - across).norm(), 1e-12);
    EXPECT_NEAR(covariance(9, 9), 1, 1e-12);
  }
}

// Every landmark is said to lie on one plane, where hardly any does.
TEST_F(PlaneLifecycleTest, OnlyManyWrongMembersAskForAnotherSolve) {
  for (const bool many : {false, true}) {
    testing::PlaneScene scene(2);
    const PlaneLifecycle life(options_);
    PlaneAssignments assignments;
    assignments.created = {scene.PlaneAt(1, 0.0)};
    scene.Apply(assignments);
    std::vector<WindowLandmark>& landmarks = scene.window().landmarks();
    const std::size_t num_members = many ? landmarks.size() : 4;
    for (std::size_t l = 0; l < num_members; ++l)
      landmarks[l].planes.Add(0);
    WeighPlanes(scene.noise, scene.window());
    EXPECT_EQ(life.DetachWrongLandmarks(scene.noise, scene.Geometry(), scene.window()), many);
    EXPECT_LT(scene.window().NumPlaneLandmarks(), static_cast<int>(num_members) / 2);
    EXPECT_GE(scene.window().NumPlaneLandmarks(), 1) << "the plane goes through the first landmark";
    EXPECT_FALSE(life.DetachWrongLandmarks(scene.noise, scene.Geometry(), scene.window()));
  }
}

TEST_F(PlaneLifecycleTest, NothingOfAPlaneThatIsNotPersistentLeaves) {
  PlaneLifecycle life(options_);
  AddPlanes(life, {1, 2});
  window().planes[0].persistent = true;
  window().measurements = {testing::MeasurementOf(PlaneId{1}, window().frames[0]),
                           testing::MeasurementOf(PlaneId{2}, window().frames[0])};
  MarginalizationPlan plan(window());
  plan.drop_frame[0] = 1;
  plan.drop_landmark[0] = 1;
  life.CutNonPersistent(plan, window());
  EXPECT_EQ(window().CountPlaneLandmarks(), (std::vector<int>{1, 0}));
  ASSERT_EQ(window().measurements.size(), 1u);
  EXPECT_EQ(window().measurements[0].plane, PlaneId{1});
}

TEST_F(PlaneLifecycleTest, LandmarksThatNoLongerFitLeaveAfterTheRemovalOfOutliers) {
  PlaneLifecycle life(options_);
  AddPlanes(life, {1});
  life.FollowOutlierRemoval(scene_.noise, scene_.Geometry(), window());
  EXPECT_EQ(window().CountPlaneLandmarks(), std::vector<int>{1});
  window().landmarks()[0].inverse_distance *= 0.8;
  life.FollowOutlierRemoval(scene_.noise, scene_.Geometry(), window());
  EXPECT_TRUE(window().planes.empty());
}

}  // namespace
}  // namespace facet
