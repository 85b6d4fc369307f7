// SPDX-License-Identifier: BSD-2-Clause
#include "facet/loop/upright_pose.h"

#include <numbers>

#include <gtest/gtest.h>

#include "facet/base/random.h"

namespace facet {
namespace {

UprightPose RandomPose(Rng& random) {
  return {random.Uniform(-std::numbers::pi, std::numbers::pi), 2 * random.Normal3()};
}

SeenPoint See(const UprightPose& T_BA, const Vector3d& p_A) {
  return {p_A, (T_BA * p_A).normalized()};
}

double Difference(const UprightPose& a, const UprightPose& b) {
  return std::abs(std::remainder(a.yaw_rad - b.yaw_rad, 2 * std::numbers::pi)) + (a.p - b.p).norm();
}

TEST(UprightPoseTest, IsAGroup) {
  Rng random(1);
  for (int i = 0; i < 50; ++i) {
    const UprightPose a = RandomPose(random), b = RandomPose(random);
    const Vector3d x = random.Normal3();
    EXPECT_LT(((a * b) * x - a * (b * x)).norm(), 1e-12);
    EXPECT_LT((a.Inverse() * (a * x) - x).norm(), 1e-12);
    EXPECT_LT((a.ToSE3() * x - a * x).norm(), 1e-12);
  }
}

TEST(UprightPoseTest, TwoPointsGiveThePoseAmongAtMostTwo) {
  Rng random(3);
  for (int i = 0; i < 500; ++i) {
    const UprightPose truth = RandomPose(random);
    const SeenPoint first = See(truth, 3 * random.Normal3()),
                    second = See(truth, 3 * random.Normal3());
    const auto poses = UprightPosesFromTwo(first, second);
    ASSERT_LE(poses.size(), 2U);
    double nearest = 1e9;
    for (const UprightPose& pose : poses) {
      nearest = std::min(nearest, Difference(pose, truth));
      for (const SeenPoint& point : {first, second})
        EXPECT_LT((pose * point.p_A).normalized().cross(point.bearing_B).norm(), 1e-7) << i;
    }
    EXPECT_LT(nearest, 1e-5) << i;
  }
}

// All at the height of the camera: two bearings in a plane are too few for a place in it.
TEST(UprightPoseTest, TwoPointsOnTheHorizonGiveNone) {
  const UprightPose truth{0.3, Vector3d(1, 2, -1.2)};
  const SeenPoint first = See(truth, Vector3d(4, 1, 1.2)),
                  second = See(truth, Vector3d(2, -3, 1.2));
  EXPECT_TRUE(UprightPosesFromTwo(first, second).empty());
}

TEST(UprightPoseTest, OnePointTwiceGivesNone) {
  const SeenPoint point = See({0.2, Vector3d(1, 0, 0)}, Vector3d(3, 1, 1));
  EXPECT_TRUE(UprightPosesFromTwo(point, point).empty());
}

TEST(UprightPoseTest, ConsensusIsFoundAmongTwoThirdsOutliers) {
  Rng random(5);
  const UprightPose truth{-2.1, Vector3d(0.5, -1, 0.3)};
  std::vector<SeenPoint> points;
  for (int i = 0; i < 60; ++i) {
    points.push_back(See(truth, Vector3d(5, 0, 0) + 1.5 * random.Normal3()));
    if (i >= 20) points.back().bearing_B = random.UnitVector();
  }
  const auto found = FindUprightPose(points, 0.01, 300);
  ASSERT_TRUE(found);
  EXPECT_LT(Difference(found->T_BA, truth), 1e-6);
  EXPECT_GE(found->inliers.size(), 20U);
  EXPECT_LE(found->inliers.size(), 22U);
}

TEST(UprightPoseTest, NoPointsGiveNoConsensus) {
  EXPECT_FALSE(FindUprightPose({}, 0.01, 300));
}

}  // namespace
}  // namespace facet
