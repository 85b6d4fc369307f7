// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/track/plane_merge.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "facet/geometry/angles.h"
#include "facet/geometry/so3.h"
#include "facet/testing/regularities/test_scene.h"

namespace facet {
namespace {

/// 2 x 2 m of surface on a plane x = ..., around the given middle.
TrackedPlane MakeKnown(int id, const Vector3d& middle_W, const Vector3d& n_W = Vector3d::UnitX()) {
  PlaneCandidate candidate;
  candidate.plane_W = {n_W.normalized(), n_W.normalized().dot(middle_W)};
  candidate.centroid_W = middle_W;
  TrackedPlane known(candidate, Timestamp{0} + FromSeconds(id));
  known.Confirm(PlaneId{id}, Timestamp{});
  known.estimate.id = known.id;
  known.estimate.plane_W = candidate.plane_W;
  known.estimate.anchor_W = middle_W;
  known.estimate.is_persistent = true;
  const Matrix<3, 2> B = TangentBasis(candidate.plane_W.n);
  known.estimate.covariance.diagonal().setConstant(1e-8);
  known.estimate.covariance.block<3, 3>(6, 6) = std::pow(0.5 * kDegree, 2) * B * B.transpose();
  known.estimate.covariance(9, 9) = 0.01 * 0.01;
  const Vector3d a = B.col(0), b = B.col(1);
  known.extent.AddTriangle({middle_W - a - b, middle_W + a - b, middle_W + a + b});
  known.extent.AddTriangle({middle_W - a + b, middle_W - a - b, middle_W + a + b});
  return known;
}

MapSnapshot MapWith(PlaneId plane, const std::vector<Vector3d>& points_W) {
  MapSnapshot map;
  for (const Vector3d& p : points_W) {
    LandmarkEstimate landmark;
    landmark.id = LandmarkId{static_cast<int>(map.landmarks.size())};
    landmark.p_W = p;
    landmark.sigma_depth_m = 0.02;
    landmark.planes[0] = plane;
    map.landmarks.push_back(landmark);
  }
  return map;
}

TEST(PlaneMergeTest, TwoPartsOfAWallBecomeTheOlder) {
  for (const bool is_older_first : {true, false}) {
    std::vector<TrackedPlane> planes = {MakeKnown(3, {3, 0, 1}), MakeKnown(8, {3.01, 2.3, 1})};
    if (!is_older_first) std::swap(planes[0], planes[1]);
    planes[0].landmark_count = testing::CountOf(20);
    planes[1].landmark_count = testing::CountOf(30, 100);
    const MapSnapshot map = MapWith(PlaneId{8}, {{3, 2, 1}, {3, 2.5, 1}});
    PlaneAssignments out;
    MergeSameSurfaces(map, planes, out);
    ASSERT_EQ(planes.size(), 1u);
    EXPECT_EQ(planes[0].id, PlaneId{3});
    EXPECT_EQ(planes[0].landmark_count.num(), 50);
    EXPECT_EQ(planes[0].seen.first, Timestamp{0} + FromSeconds(3));
    EXPECT_EQ(planes[0].seen.last, Timestamp{0} + FromSeconds(8));
    EXPECT_NEAR(planes[0].extent.area_m2(), 8, 0.5);
    EXPECT_LT((planes[0].extent.Centroid(planes[0].estimate.plane_W) - Vector3d(3, 1.15, 1)).norm(),
              0.1);
    EXPECT_EQ(out.retired, std::vector{PlaneId{8}});
    ASSERT_EQ(out.attached.size(), 2u);
    EXPECT_EQ(out.attached[0].plane, PlaneId{3});
    EXPECT_TRUE(planes[0].Has(map.landmarks[0]));
  }
}

TEST(PlaneMergeTest, TheOtherSideIsAnotherSurface) {
  std::vector<TrackedPlane> planes = {MakeKnown(0, {3, 0, 1}),
                                      MakeKnown(1, {3, 1, 1}, -Vector3d::UnitX())};
  PlaneAssignments out;
  MergeSameSurfaces({}, planes, out);
  EXPECT_EQ(planes.size(), 2u);
  planes[1] = MakeKnown(1, {3, 1, 1});
  MergeSameSurfaces({}, planes, out);
  EXPECT_EQ(planes.size(), 1u);
}

TEST(PlaneMergeTest, ThreePartsBecomeOne) {
  std::vector<TrackedPlane> planes = {
      MakeKnown(0, {3, 0, 1}), MakeKnown(1, {3, 4.4, 1}), MakeKnown(2, {3, 2.2, 1})};
  const MapSnapshot map = MapWith(PlaneId{1}, {{3, 4, 1}});
  PlaneAssignments out;
  for (int k = 0; k < 2; ++k)
    MergeSameSurfaces(map, planes, out);
  ASSERT_EQ(planes.size(), 1u);
  EXPECT_EQ(out.retired.size(), 2u);
  EXPECT_EQ(planes[0].id, PlaneId{0});
}

TEST(PlaneMergeTest, DifferentSurfacesStayDifferent) {
  const Vector3d tilted(1, std::tan(3 * kDegree), 0);
  const std::vector<std::pair<Vector3d, Vector3d>> others = {
      {{3.1, 2.2, 1}, Vector3d::UnitX()},  // 10 cm behind
      {{3.1, 0, 1}, Vector3d::UnitX()},    // 10 cm behind, and hidden by it
      {{3.03, 2.2, 1}, Vector3d::UnitX()},
      {{3, 3.5, 1}, Vector3d::UnitX()},  // 1.5 m beside
      {{3, 2.2, 1}, tilted}};
  for (const auto& [middle, n] : others) {
    std::vector<TrackedPlane> planes = {MakeKnown(0, {3, 0, 1}), MakeKnown(1, middle, n)};
    PlaneAssignments out;
    MergeSameSurfaces({}, planes, out);
    EXPECT_EQ(planes.size(), 2u) << middle.transpose();
    EXPECT_TRUE(out.IsEmpty());
  }
}

TEST(PlaneMergeTest, PlanesThatAreHardlyKnownOrTooWellKnownAreNotMerged) {
  std::vector<TrackedPlane> planes = {MakeKnown(0, {3, 0, 1}), MakeKnown(1, {3, 2.2, 1})};
  PlaneAssignments out;
  planes[1].estimate.is_persistent = false;
  MergeSameSurfaces({}, planes, out);
  EXPECT_EQ(planes.size(), 2u);
  // 1.5 cm apart, both known to a millimetre.
  planes[1] = MakeKnown(1, {3.015, 2.2, 1});
  for (TrackedPlane& plane : planes)
    plane.estimate.covariance *= 0.01;
  MergeSameSurfaces({}, planes, out);
  EXPECT_EQ(planes.size(), 2u);
  planes[1] = MakeKnown(1, {3, 2.2, 1});
  planes[1].state = PlaneState::kTentative;
  MergeSameSurfaces({}, planes, out);
  EXPECT_EQ(planes.size(), 2u);
}

}  // namespace
}  // namespace facet
