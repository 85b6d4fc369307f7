// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/track/retired_planes.h"

#include <gtest/gtest.h>

#include "facet/testing/regularities/test_scene.h"

namespace facet {
namespace {

constexpr double kMaxAngle = 0.1, kMaxDistance_m = 0.05;

// 1 m2 of a plane that leans by `angle` about the vertical, `offset_m` in front of the first wall.
TrackedPlane Wall(double angle, double offset_m, double y_m, Timestamp t) {
  PlaneCandidate candidate;
  candidate.centroid_W = {3 - offset_m, y_m, 1};
  candidate.plane_W.n = {std::cos(angle), std::sin(angle), 0};
  candidate.plane_W.d = candidate.plane_W.n.dot(candidate.centroid_W);
  TrackedPlane plane(candidate, t);
  plane.estimate.plane_W = candidate.plane_W;
  const Vector3d& c = candidate.centroid_W;
  plane.extent.AddTriangle({c + Vector3d(0, -0.5, -0.5), c + Vector3d(0, 0.5, -0.5), c});
  plane.extent.AddTriangle({c + Vector3d(0, 0.5, 0.5), c + Vector3d(0, -0.5, 0.5), c});
  return plane;
}

TrackedPlane Solved(TrackedPlane plane, PlaneId id) {
  plane.Confirm(id, Timestamp{});
  plane.landmark_count = testing::CountOf(5);
  PlaneEstimate estimate = plane.estimate;
  estimate.id = id;
  estimate.covariance = Matrix<10, 10>::Identity();
  plane.Update(estimate);
  return plane;
}

TEST(RetiredPlanesTest, APlaneGetsItsIdBack) {
  RetiredPlanes retired;
  retired.Add(Solved(Wall(0, 0, 0, Timestamp{5}), PlaneId{3}));
  TrackedPlane again = Wall(0.05, 0.03, 0.2, Timestamp{900});
  again.landmark_count = testing::CountOf(2, 100);
  EXPECT_EQ(retired.Reidentify(kMaxAngle, kMaxDistance_m, again), PlaneId{3});
  EXPECT_EQ(again.seen.first, Timestamp{5});
  EXPECT_EQ(again.seen.last, Timestamp{900});
  EXPECT_EQ(again.landmark_count.num(), 7);
  EXPECT_TRUE(again.best.has_value());
  EXPECT_TRUE(again.extent.HasSurface({3, -0.3, 0.6}));  // where only the retired one had been seen
  EXPECT_TRUE(retired.reachable().empty());
  TrackedPlane third = Wall(0, 0, 0, Timestamp{990});
  EXPECT_FALSE(retired.Reidentify(kMaxAngle, kMaxDistance_m, third).has_value());
}

TEST(RetiredPlanesTest, AnotherPlaneDoesNot) {
  RetiredPlanes retired;
  retired.Add(Solved(Wall(0, 0, 0, Timestamp{5}), PlaneId{3}));
  for (TrackedPlane other : {Wall(0.15, 0, 0, Timestamp{900}),
                             Wall(0, 0.08, 0, Timestamp{900}),
                             Wall(0, 0, 4, Timestamp{900})}) {
    EXPECT_FALSE(retired.Reidentify(kMaxAngle, kMaxDistance_m, other).has_value());
    EXPECT_TRUE(other.IsTentative());
  }
  EXPECT_EQ(retired.reachable().size(), 1u);
}

TEST(RetiredPlanesTest, WhatWasNeverSolvedForLeavesNoTrace) {
  RetiredPlanes retired;
  retired.Add(Wall(0, 0, 0, Timestamp{5}));
  EXPECT_TRUE(retired.reachable().empty());
}

TEST(RetiredPlanesTest, NothingIsReidentifiedAcrossANewStart) {
  RetiredPlanes retired;
  retired.Add(Solved(Wall(0, 0, 0, Timestamp{5}), PlaneId{3}));
  retired.StartOver();
  TrackedPlane again = Wall(0, 0, 0, Timestamp{900});
  EXPECT_FALSE(retired.Reidentify(kMaxAngle, kMaxDistance_m, again).has_value());
  EXPECT_EQ(retired.unreachable().size(), 1u);
  EXPECT_TRUE(retired.reachable().empty());
  retired.Add(Solved(Wall(0, 0, 0, Timestamp{950}), PlaneId{4}));
  EXPECT_EQ(retired.Reidentify(kMaxAngle, kMaxDistance_m, again), PlaneId{4});
}

TEST(RetiredPlanesTest, ThatPlaneIsReportedAsItWasKnownBest) {
  TrackedPlane plane = Solved(Wall(0, 0, 0, Timestamp{5}), PlaneId{3});
  const auto update = [&](double variance, double d, bool is_persistent) {
    PlaneEstimate estimate = plane.estimate;
    estimate.covariance = variance * Matrix<10, 10>::Identity();
    estimate.plane_W.d = d;
    estimate.is_persistent = is_persistent;
    plane.Update(estimate);
  };
  update(0.1, 3.1, false);
  update(0.5, 3.2, false);  // some of its landmarks have gone
  EXPECT_EQ(plane.best->plane_W.d, 3.1);
  EXPECT_EQ(plane.estimate.plane_W.d, 3.2);
  update(0.2, 3.3, true);  // what has persistent follows the whole map
  EXPECT_EQ(plane.best->plane_W.d, 3.3);
  update(0.0, 3.4, false);  // not solved for
  EXPECT_EQ(plane.best->plane_W.d, 3.3);
}

}  // namespace
}  // namespace facet
