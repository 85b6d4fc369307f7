// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/report/plane_records.h"

#include <cmath>

#include <gtest/gtest.h>

#include "facet/geometry/angles.h"
#include "facet/geometry/so3.h"
#include "facet/testing/regularities/test_scene.h"

namespace facet {
namespace {

// A square around `middle_W` on a wall that is turned by `yaw_deg` from x = const.
TrackedPlane Wall(
    int id, const Vector3d& middle_W, double yaw_deg, double sigma_deg, double side_m = 2) {
  PlaneCandidate candidate;
  candidate.plane_W.n = {std::cos(yaw_deg * kDegree), std::sin(yaw_deg * kDegree), 0};
  candidate.plane_W.d = candidate.plane_W.n.dot(middle_W);
  candidate.centroid_W = middle_W;
  TrackedPlane known(candidate, Timestamp{0} + FromSeconds(id));
  known.Confirm(PlaneId{id}, Timestamp{});
  known.landmark_count = testing::CountOf(10, 100 * id);
  PlaneEstimate estimate;
  estimate.id = known.id;
  estimate.plane_W = candidate.plane_W;
  estimate.anchor_W = middle_W;
  const Matrix<3, 2> B = TangentBasis(candidate.plane_W.n);
  // The pose that it was seen from is of no concern.
  estimate.covariance.topLeftCorner<6, 6>() = 1e4 * Matrix<6, 6>::Identity();
  estimate.covariance.block<3, 3>(6, 6) = std::pow(sigma_deg * kDegree, 2) * B * B.transpose();
  estimate.covariance(9, 9) = 0.01 * 0.01;
  known.best = estimate;
  const Vector3d a = side_m / 2 * B.col(0), b = side_m / 2 * B.col(1);
  known.extent.AddTriangle({middle_W - a - b, middle_W + a - b, middle_W + a + b});
  known.extent.AddTriangle({middle_W - a + b, middle_W - a - b, middle_W + a + b});
  return known;
}

TEST(PlaneRecordsTest, OneSurfaceHasOneRecordThatIsAsItWasKnownBest) {
  const std::vector<TrackedPlane> planes = {Wall(4, {3, 2.1, 1}, 0.1, 0.2),
                                            Wall(1, {3, 0, 1}, 1, 1)};
  const std::vector<PlaneRecord> records = MakeRecords(planes, true);
  ASSERT_EQ(records.size(), 1u);
  EXPECT_EQ(records[0].id, PlaneId{1});
  EXPECT_EQ(records[0].merged_ids, std::vector{PlaneId{4}});
  EXPECT_EQ(records[0].num_landmarks, 20);
  EXPECT_EQ(records[0].first_seen, Timestamp{0} + FromSeconds(1));
  EXPECT_EQ(records[0].last_seen, Timestamp{0} + FromSeconds(4));
  EXPECT_NEAR(records[0].area_m2, 8, 0.6);
  EXPECT_NEAR(records[0].sigma_normal_rad, 0.2 * kDegree, 1e-9);
  EXPECT_EQ(records[0].plane_W.n, planes[0].best->plane_W.n);
  for (const Vector3d& corner : records[0].outline_W)
    EXPECT_NEAR(records[0].plane_W.SignedDistance(corner), 0, 1e-9);
}

TEST(PlaneRecordsTest, ThreePiecesAreOneInAnyOrder) {
  const std::vector<TrackedPlane> planes = {
      Wall(0, {3, 0, 1}, 0, 0.5), Wall(1, {3, 4.2, 1}, 0, 0.5), Wall(2, {3, 2.1, 1}, 0, 0.5)};
  const std::vector<PlaneRecord> records = MakeRecords(planes, true);
  ASSERT_EQ(records.size(), 1u);
  EXPECT_EQ(records[0].merged_ids.size(), 2u);
}

TEST(PlaneRecordsTest, WhatDiffersOrIsApartKeepsItsRecord) {
  const TrackedPlane wall = Wall(0, {3, 0, 1}, 0, 0.5);
  const std::vector<TrackedPlane> others = {Wall(1, {3.1, 0, 1}, 0, 0.5),   // 10 cm before it
                                            Wall(1, {3, 0, 1}, 180, 0.5),   // seen from behind
                                            Wall(1, {3, 0, 1}, 8, 5),       // leans
                                            Wall(1, {3, 0, 1}, 3, 0.1),     // and is sure of it
                                            Wall(1, {3, 4.5, 1}, 0, 0.5)};  // 2.5 m beside it
  for (const TrackedPlane& other : others) {
    const std::vector<PlaneRecord> records = MakeRecords(std::vector{wall, other}, true);
    EXPECT_EQ(records.size(), 2u) << other.best->plane_W.n.transpose() << ", "
                                  << other.best->anchor_W.transpose();
  }
  EXPECT_EQ(MakeRecords(std::vector{wall, Wall(1, {3, 0, 1}, 3, 1)}, true).size(), 1u);
}

TEST(PlaneRecordsTest, LargePiecesAreOneAcrossAGap) {
  const TrackedPlane wall = Wall(0, {3, 0, 1}, 0, 0.5, 3);
  const auto num_records = [&](const TrackedPlane& other) {
    return MakeRecords(std::vector{wall, other}, true).size();
  };
  EXPECT_EQ(num_records(Wall(1, {3, 5, 1}, 0, 0.5, 3)), 1u);      // 2 m between them
  EXPECT_EQ(num_records(Wall(1, {3, 7.5, 1}, 0, 0.5, 3)), 2u);    // 4.5 m
  EXPECT_EQ(num_records(Wall(1, {3, 3.7, 1}, 0, 0.5, 2.2)), 1u);  // 1.1 m to 4.8 m^2
  EXPECT_EQ(num_records(Wall(1, {3, 3.6, 1}, 0, 0.5, 1.8)), 2u);  // 1.2 m to 3.2 m^2
  // 1 deg with a sigma of half of it: 7 cm at the middle of the other, half of that between them.
  EXPECT_EQ(num_records(Wall(1, {3, 4, 1}, 1, 0.5, 3)), 1u);
  // Neither is known well, but half-way they are 8 cm apart.
  TrackedPlane step = Wall(1, {3.08, 3.2, 1}, 0, 0.5, 3);
  step.best->covariance(9, 9) = 0.1 * 0.1;
  EXPECT_EQ(num_records(step), 2u);
  step.best->plane_W.d -= 0.04;
  EXPECT_EQ(num_records(step), 1u);
}

TrackedPlane Scattered(TrackedPlane plane, double scatter, int num_keyframes) {
  for (int k = 0; k < num_keyframes; ++k)
    plane.fit.scatter.Add(scatter);
  return plane;
}

TEST(PlaneRecordsTest, ARowOfThingsIsNoPlane) {
  const auto is_told = [](double side_m, double scatter, int num_keyframes) {
    const TrackedPlane plane =
        Scattered(Wall(0, {3, 0, 1}, 0, 0.5, side_m), scatter, num_keyframes);
    return !MakeRecords(std::vector{plane}, true).empty();
  };
  EXPECT_FALSE(is_told(0.8, 0.55, 5));
  EXPECT_TRUE(is_told(0.8, 0.45, 5));
  EXPECT_TRUE(is_told(1.2, 0.55, 5));
  EXPECT_TRUE(is_told(0.8, 0.55, 4));  // too early to tell
}

TEST(PlaneRecordsTest, ASmallPlaneWhoseLeanIsUnknownIsNotTold) {
  const auto is_told = [](double side_m, double sigma_deg) {
    return !MakeRecords(std::vector{Wall(0, {3, 0, 1}, 0, sigma_deg, side_m)}, true).empty();
  };
  EXPECT_FALSE(is_told(0.8, 2.1));
  EXPECT_TRUE(is_told(0.8, 1.9));
  EXPECT_TRUE(is_told(1.2, 2.1));
}

TEST(PlaneRecordsTest, WhatWasBentMostOfTheTimeIsNotTold) {
  const auto is_told = [](int num_curved, int num_judged) {
    TrackedPlane plane = Wall(0, {3, 0, 1}, 0, 0.5, 3);
    for (int k = 0; k < num_judged; ++k)
      plane.fit.curvature.Add(k < num_curved);
    return !MakeRecords(std::vector{plane}, true).empty();
  };
  EXPECT_FALSE(is_told(4, 7));
  EXPECT_TRUE(is_told(4, 8));
  EXPECT_TRUE(is_told(4, 4));  // too early to tell
  // A board before a wall that is known to be one surface with it.
  std::vector<TrackedPlane> planes = {Wall(0, {3, 0, 1}, 0, 0.5, 3), Wall(1, {3, 2, 1}, 0, 0.5, 1)};
  for (int k = 0; k < 60; ++k)
    planes[1].fit.curvature.Add(true);
  for (int k = 0; k < 10; ++k)
    planes[0].fit.curvature.Add(false);
  EXPECT_EQ(MakeRecords(planes, true).size(), 1u);
}

TEST(PlaneRecordsTest, APieceOfAWallMayScatter) {
  const TrackedPlane wall = Scattered(Wall(0, {3, 0, 1}, 0, 0.5, 3), 0.2, 9);
  const TrackedPlane piece = Scattered(Wall(1, {3, 2, 1}, 0, 0.5, 0.8), 0.6, 9);
  const TrackedPlane other = Scattered(Wall(2, {3, 2.9, 1}, 0, 0.5, 0.8), 0.6, 9);
  const std::vector<PlaneRecord> records = MakeRecords(std::vector{wall, piece}, true);
  ASSERT_EQ(records.size(), 1u);
  EXPECT_EQ(records[0].merged_ids, std::vector{PlaneId{1}});
  EXPECT_EQ(MakeRecords(std::vector{piece, other}, true).size(), 1u);  // 1.3 m^2 together
  // Small pieces scatter as they do on average.
  const TrackedPlane flat = Scattered(Wall(2, {3, 2.7, 1}, 0, 0.5, 0.6), 0.0, 9);
  const TrackedPlane things = Scattered(Wall(1, {3, 2, 1}, 0, 0.5, 0.6), 0.8, 9);
  EXPECT_EQ(MakeRecords(std::vector{things, flat}, true).size(), 1u);
  EXPECT_TRUE(MakeRecords(std::vector{things}, true).empty());
}

TEST(PlaneRecordsTest, AcrossAResetNothingIsUnitedAndWhatWasNeverSolvedIsNotTold) {
  std::vector<TrackedPlane> planes = {Wall(0, {3, 0, 1}, 0, 0.5), Wall(1, {3, 0, 1}, 0, 0.5)};
  EXPECT_EQ(MakeRecords(planes, false).size(), 2u);
  planes[0].best.reset();
  const std::vector<PlaneRecord> records = MakeRecords(planes, true);
  ASSERT_EQ(records.size(), 1u);
  EXPECT_EQ(records[0].id, PlaneId{1});
  EXPECT_TRUE(MakeRecords({}, true).empty());
}

}  // namespace
}  // namespace facet
