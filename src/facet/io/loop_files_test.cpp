// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/loop_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace facet {
namespace {

OdometryPose PoseAt(std::int64_t t_s, const Vector3d& p, int segment = 0) {
  return {{Timestamp{t_s * 1'000'000'000}, SE3(Quaterniond::Identity(), p)}, segment};
}

TEST(LoopFilesTest, CorrectionsAreInterpolatedWhereTheBodyIs) {
  MapCorrection first, second;
  first.t = Timestamp{10'000'000'000};
  second.t = Timestamp{20'000'000'000};
  // A turn about a body that is far from the origin, and half a metre up.
  const Vector3d body(100, 0, 0);
  second.T_MW.yaw_rad = 0.2;
  second.T_MW.p = body + Vector3d(0, 0, 0.5) - UprightPose{0.2, Vector3d::Zero()} * body;
  const std::vector<OdometryPose> odometry = {
      PoseAt(5, body), PoseAt(10, body), PoseAt(15, body), PoseAt(20, body), PoseAt(25, body)};
  const auto moved = MoveIntoMap(odometry, std::vector{first, second});
  ASSERT_EQ(moved.size(), odometry.size());
  const double heights[] = {0, 0, 0.25, 0.5, 0.5}, yaws[] = {0, 0, 0.1, 0.2, 0.2};
  for (std::size_t i = 0; i < moved.size(); ++i) {
    EXPECT_EQ(moved[i].t, odometry[i].pose.t);
    EXPECT_LT((moved[i].T_WB.p - body - Vector3d(0, 0, heights[i])).norm(), 1e-9) << i;
    EXPECT_NEAR(2 * std::atan2(moved[i].T_WB.q.z(), moved[i].T_WB.q.w()), yaws[i], 1e-9) << i;
  }
}

TEST(LoopFilesTest, WithoutCorrectionsPosesStay) {
  const std::vector<OdometryPose> odometry = {PoseAt(5, Vector3d(1, 2, 3))};
  EXPECT_EQ(MoveIntoMap(odometry, {})[0].T_WB.p, odometry[0].pose.T_WB.p);
}

// The worlds before and after a loss are far from each other.
TEST(LoopFilesTest, NothingIsInterpolatedAcrossALoss) {
  MapCorrection before, after;
  before.t = Timestamp{10'000'000'000};
  after.t = Timestamp{20'000'000'000};
  after.segment = 1;
  after.T_MW.p = Vector3d(100, 0, 0);
  const std::vector<OdometryPose> odometry = {PoseAt(14, Vector3d::Zero(), 0),
                                              PoseAt(15, Vector3d::Zero(), 1),
                                              PoseAt(16, Vector3d::Zero(), 1),
                                              PoseAt(30, Vector3d::Zero(), 2)};
  const auto moved = MoveIntoMap(odometry, std::vector{before, after});
  const double expected_x[] = {0, 100, 100, 0};
  for (std::size_t i = 0; i < moved.size(); ++i)
    EXPECT_EQ(moved[i].T_WB.p, Vector3d(expected_x[i], 0, 0)) << i;
}

TEST(LoopFilesTest, ClosuresAreLinesWithTheirVerdict) {
  ClosureRecord closure;
  closure.t = Timestamp{1403636584763555584};
  closure.t_place = Timestamp{1403636580013555456};
  closure.num_matches = 31;
  closure.num_inliers = 80;
  closure.num_visible = 95;
  closure.T_WplaceWquery.p = Vector3d(0.25, 0, -1);
  closure.sigma_m = 0.002;
  closure.verdict = kClosureAccepted;
  const std::string text = ClosuresCsv(std::vector{closure});
  EXPECT_THAT(text, ::testing::StartsWith("timestamp_ns,place_timestamp_ns,"));
  EXPECT_THAT(text,
              ::testing::HasSubstr("\n1403636584763555584,1403636580013555456,31,80,95,0,0.25,0,-1,"
                                   "0.002,0,accepted\n"));
}

}  // namespace
}  // namespace facet
