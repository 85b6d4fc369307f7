// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/former_planes.h"

#include <gtest/gtest.h>

#include "facet/regularities/test_scene.h"

namespace facet {
namespace {

constexpr double kMaxAngle = 0.1, kMaxDistance_m = 0.05;

// 1 m2 of a plane that leans by `angle` about the vertical, `offset_m` in front of the first wall.
KnownPlane Wall(double angle, double offset_m, double y_m, Timestamp t) {
  PlaneCandidate candidate;
  candidate.centroid_W = {3 - offset_m, y_m, 1};
  candidate.plane_W.n = {std::cos(angle), std::sin(angle), 0};
  candidate.plane_W.d = candidate.plane_W.n.dot(candidate.centroid_W);
  KnownPlane plane(candidate, t);
  plane.estimate.plane_W = candidate.plane_W;
  const Vector3d& c = candidate.centroid_W;
  plane.support.AddTriangle({c + Vector3d(0, -0.5, -0.5), c + Vector3d(0, 0.5, -0.5), c});
  plane.support.AddTriangle({c + Vector3d(0, 0.5, 0.5), c + Vector3d(0, -0.5, 0.5), c});
  return plane;
}

KnownPlane Solved(KnownPlane plane, PlaneId id) {
  plane.id = id;
  plane.members = testing::CountOf(5);
  PlaneEstimate estimate = plane.estimate;
  estimate.id = id;
  estimate.covariance = Matrix<10, 10>::Identity();
  plane.Update(estimate);
  return plane;
}

TEST(FormerPlanesTest, APlaneGoesOnUnderItsName) {
  FormerPlanes former;
  former.Add(Solved(Wall(0, 0, 0, Timestamp{5}), PlaneId{3}));
  KnownPlane again = Wall(0.05, 0.03, 0.2, Timestamp{900});
  again.members = testing::CountOf(2, 100);
  ASSERT_TRUE(former.Recall(kMaxAngle, kMaxDistance_m, again));
  EXPECT_EQ(again.id, PlaneId{3});
  EXPECT_EQ(again.first_seen, Timestamp{5});
  EXPECT_EQ(again.last_seen, Timestamp{900});
  EXPECT_EQ(again.members.num(), 7);
  EXPECT_TRUE(again.best.has_value());
  EXPECT_TRUE(again.support.HasSurface({3, -0.3, 0.6}));  // where only the former one had been seen
  EXPECT_TRUE(former.reachable().empty());
  KnownPlane third = Wall(0, 0, 0, Timestamp{990});
  EXPECT_FALSE(former.Recall(kMaxAngle, kMaxDistance_m, third));
}

TEST(FormerPlanesTest, AnotherPlaneDoesNot) {
  FormerPlanes former;
  former.Add(Solved(Wall(0, 0, 0, Timestamp{5}), PlaneId{3}));
  for (KnownPlane other : {Wall(0.15, 0, 0, Timestamp{900}),
                           Wall(0, 0.08, 0, Timestamp{900}),
                           Wall(0, 0, 4, Timestamp{900})}) {
    EXPECT_FALSE(former.Recall(kMaxAngle, kMaxDistance_m, other));
    EXPECT_TRUE(other.IsTentative());
  }
  EXPECT_EQ(former.reachable().size(), 1u);
}

TEST(FormerPlanesTest, WhatWasNeverSolvedForLeavesNoTrace) {
  FormerPlanes former;
  former.Add(Wall(0, 0, 0, Timestamp{5}));
  EXPECT_TRUE(former.reachable().empty());
}

TEST(FormerPlanesTest, NothingIsRecalledFromBeforeANewStart) {
  FormerPlanes former;
  former.Add(Solved(Wall(0, 0, 0, Timestamp{5}), PlaneId{3}));
  former.StartOver();
  KnownPlane again = Wall(0, 0, 0, Timestamp{900});
  EXPECT_FALSE(former.Recall(kMaxAngle, kMaxDistance_m, again));
  EXPECT_EQ(former.unreachable().size(), 1u);
  EXPECT_TRUE(former.reachable().empty());
  former.Add(Solved(Wall(0, 0, 0, Timestamp{950}), PlaneId{4}));
  EXPECT_TRUE(former.Recall(kMaxAngle, kMaxDistance_m, again));
  EXPECT_EQ(again.id, PlaneId{4});
}

TEST(FormerPlanesTest, ThatPlaneIsReportedAsItWasKnownBest) {
  KnownPlane plane = Solved(Wall(0, 0, 0, Timestamp{5}), PlaneId{3});
  const auto update = [&](double variance, double d, bool is_settled) {
    PlaneEstimate estimate = plane.estimate;
    estimate.covariance = variance * Matrix<10, 10>::Identity();
    estimate.plane_W.d = d;
    estimate.is_settled = is_settled;
    plane.Update(estimate);
  };
  update(0.1, 3.1, false);
  update(0.5, 3.2, false);  // some of its landmarks have gone
  EXPECT_EQ(plane.best->plane_W.d, 3.1);
  EXPECT_EQ(plane.estimate.plane_W.d, 3.2);
  update(0.2, 3.3, true);  // what has settled follows the whole map
  EXPECT_EQ(plane.best->plane_W.d, 3.3);
  update(0.0, 3.4, false);  // not solved for
  EXPECT_EQ(plane.best->plane_W.d, 3.3);
}

}  // namespace
}  // namespace facet
