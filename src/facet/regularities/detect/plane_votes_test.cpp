// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/detect/plane_votes.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/geometry/angles.h"

namespace facet {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

struct Vote {
  Vector3d centre_W, n_W;
  double area_m2;
};

// 4 x 2.5 m of wall whose middle is 3 m from `viewer_W`; the faces' normals are 8 deg off.
std::vector<Vote> WallVotesAt(double azimuth, const Vector3d& viewer_W, Rng& rng) {
  const Vector3d n(std::cos(azimuth), std::sin(azimuth), 0);
  const Vector3d along(-n.y(), n.x(), 0);
  std::vector<Vote> votes;
  for (int i = 0; i < 120; ++i) {
    const Vector3d centre = viewer_W + (3 + 0.01 * rng.Normal()) * n + rng.Uniform(-2, 2) * along +
                            rng.Uniform(-1.25, 1.25) * Vector3d::UnitZ();
    const Vector3d tilt = 8 * kDegree * rng.Normal3();
    votes.push_back({centre, -(n + tilt.cross(n)).normalized(), 10.0 / 120});
  }
  return votes;
}

void ExpectVotesFindEveryWall(const Vector3d& viewer_W) {
  Rng rng(3);
  WallVotes votes;
  for (int degree = 0; degree <= 180; ++degree) {
    const double azimuth = degree * kDegree;
    votes.Reset(viewer_W, 5, 0.03, 5 * kDegree);
    for (const Vote& vote : WallVotesAt(azimuth, viewer_W, rng))
      votes.Add(vote.centre_W, vote.n_W, vote.area_m2);
    const auto peak = votes.Highest();
    ASSERT_TRUE(peak) << degree;
    const Vector3d n(std::cos(azimuth), std::sin(azimuth), 0);
    // Columns are 3 deg apart: half of that, and a little for the noise.
    EXPECT_GT(std::abs(peak->plane_W.n.dot(n)), std::cos(2 * kDegree)) << degree;
    EXPECT_LT(std::abs(peak->plane_W.SignedDistance(viewer_W + 3 * n)), 0.03) << degree;
    EXPECT_GT(peak->area_m2, 2) << degree;
  }
}

TEST(WallVotesTest, FindEveryAzimuth) {
  ExpectVotesFindEveryWall(Vector3d(0.3, -0.2, 1));
}

TEST(WallVotesTest, DoNotCareWhereTheWorldBegins) {
  ExpectVotesFindEveryWall(Vector3d(50, -50, 20));
}

TEST(WallVotesTest, TakenBackLeaveNothing) {
  Rng rng(4);
  WallVotes votes;
  votes.Reset(Vector3d::Zero(), 5, 0.03, 5 * kDegree);
  const std::vector<Vote> wall = WallVotesAt(1.0, Vector3d::Zero(), rng);
  for (const Vote& vote : wall)
    votes.Add(vote.centre_W, vote.n_W, vote.area_m2);
  for (const Vote& vote : wall)
    votes.Add(vote.centre_W, vote.n_W, -vote.area_m2);
  const auto peak = votes.Highest();
  EXPECT_LT(peak ? peak->area_m2 : 0, 1e-4);
}

TEST(WallVotesTest, TakingAWallBackUncoversTheOneBehind) {
  Rng rng(5);
  WallVotes votes;
  votes.Reset(Vector3d::Zero(), 5, 0.03, 5 * kDegree);
  const std::vector<Vote> wall = WallVotesAt(0.02, Vector3d::Zero(), rng);
  for (const Vote& vote : wall) {
    votes.Add(vote.centre_W, vote.n_W, vote.area_m2);
    votes.Add(vote.centre_W + 0.4 * Vector3d::UnitX(), vote.n_W, 0.5 * vote.area_m2);
  }
  for (const Vote& vote : wall)
    votes.Add(vote.centre_W, vote.n_W, -vote.area_m2);
  const auto peak = votes.Highest();
  ASSERT_TRUE(peak);
  EXPECT_NEAR(std::abs(peak->plane_W.d), 3.4, 0.03);
}

TEST(WallVotesTest, CountAtBothEndsOfTheRange) {
  for (const double distance : {-5.0, 5.0}) {
    WallVotes votes;
    votes.Reset(Vector3d::Zero(), 5, 0.03, 5 * kDegree);
    votes.Add(Vector3d(distance, 0, 0), Vector3d::UnitX(), 1.0);
    const auto peak = votes.Highest();
    ASSERT_TRUE(peak);
    EXPECT_NEAR(peak->plane_W.SignedDistance(Vector3d(distance, 0, 0)), 0, 0.01);
    EXPECT_NEAR(peak->area_m2, 1.0, 0.02);
  }
}

TEST(WallVotesTest, EraseTakesOnlyThePeak) {
  WallVotes votes;
  votes.Reset(Vector3d(1, 2, 0), 5, 0.03, 5 * kDegree);
  const Vector3d n(std::cos(3.1), std::sin(3.1), 0);
  votes.Add(Vector3d(1, 2, 0) + 2 * n, n, 1.0);
  votes.Add(Vector3d(1, 2, 0) + 3 * n, n, 0.5);
  const auto first = votes.Highest();
  ASSERT_TRUE(first);
  votes.Erase(first->plane_W);
  // What the vote left in the neighbouring columns is lower than the other wall or is its own.
  const auto second = votes.Highest();
  ASSERT_TRUE(second);
  EXPECT_LT(second->area_m2, first->area_m2);
  // The same plane with the opposite normal is the same peak.
  WallVotes other;
  other.Reset(Vector3d::Zero(), 5, 0.03, 5 * kDegree);
  other.Add(2 * n, n, 1.0);
  other.Erase({-other.Highest()->plane_W.n, -other.Highest()->plane_W.d});
  EXPECT_LT(other.Highest()->area_m2, 0.95);
}

TEST(WallVotesTest, FacesThatAreNotNumbersDoNoHarm) {
  Rng rng(6);
  WallVotes votes;
  votes.Reset(Vector3d::Zero(), 5, 0.03, 5 * kDegree);
  for (const Vote& vote : WallVotesAt(1.0, Vector3d::Zero(), rng))
    votes.Add(vote.centre_W, vote.n_W, vote.area_m2);
  votes.Add(Vector3d::Constant(kNaN), Vector3d::UnitX(), 1);
  votes.Add(Vector3d(3, 0, 0), Vector3d::Constant(kNaN), 1);
  votes.Add(Vector3d(3, 0, 0), Vector3d::UnitX(), kNaN);
  votes.Add(Vector3d::Constant(std::numeric_limits<double>::infinity()), Vector3d::UnitX(), 1);
  const auto peak = votes.Highest();
  ASSERT_TRUE(peak);
  EXPECT_NEAR(std::abs(peak->plane_W.d), 3, 0.03);
  EXPECT_TRUE(std::isfinite(peak->area_m2));
}

TEST(HeightVotesTest, FindEveryHeight) {
  Rng rng(7);
  HeightVotes votes;
  for (const double moved : {0.0, 50.0, -50.0}) {
    for (double height = -2; height <= 2; height += 0.013) {
      votes.Reset(moved - 2.5, moved + 2.5, 0.03);
      for (int i = 0; i < 100; ++i)
        votes.Add(moved + height + 0.02 * rng.Normal(), 0.05);
      const auto peak = votes.Highest();
      ASSERT_TRUE(peak);
      EXPECT_EQ(peak->plane_W.n, Vector3d::UnitZ());
      EXPECT_NEAR(peak->plane_W.d, moved + height, 0.01);
      // 5 m^2, thinned by the noise: 3 / sqrt(3^2 + 2^2).
      EXPECT_NEAR(peak->area_m2, 5 * 0.83, 0.6);
    }
  }
}

TEST(HeightVotesTest, TakenBackLeaveNothing) {
  Rng rng(8);
  HeightVotes votes;
  votes.Reset(0, 3, 0.03);
  std::vector<double> heights;
  for (int i = 0; i < 200; ++i)
    heights.push_back(rng.Uniform(0, 3));
  for (const double height : heights)
    votes.Add(height, 0.1);
  for (const double height : heights)
    votes.Add(height, -0.1);
  const auto peak = votes.Highest();
  EXPECT_LT(peak ? peak->area_m2 : 0, 1e-4);
}

TEST(HeightVotesTest, CountAtBothEndsAndInAnEmptyRange) {
  HeightVotes votes;
  for (const double height : {1.0, 4.0}) {
    votes.Reset(1, 4, 0.03);
    votes.Add(height, 1.0);
    ASSERT_TRUE(votes.Highest());
    EXPECT_NEAR(votes.Highest()->plane_W.d, height, 0.005);
    EXPECT_NEAR(votes.Highest()->area_m2, 1, 0.02);
  }
  votes.Reset(2, 2, 0.03);
  EXPECT_FALSE(votes.Highest());
  votes.Add(2, 1.0);
  ASSERT_TRUE(votes.Highest());
  EXPECT_NEAR(votes.Highest()->plane_W.d, 2, 0.005);
  votes.Erase({Vector3d::UnitZ(), 2});
  EXPECT_FALSE(votes.Highest());
}

TEST(HeightVotesTest, HeightsThatAreNotNumbersOrOutOfRangeDoNoHarm) {
  HeightVotes votes;
  votes.Reset(0, 3, 0.03);
  votes.Add(1, 1.0);
  for (const double height : {kNaN, 1e300, -1e300, std::numeric_limits<double>::infinity(), 50.0})
    votes.Add(height, 5.0);
  votes.Add(1, kNaN);
  ASSERT_TRUE(votes.Highest());
  EXPECT_NEAR(votes.Highest()->plane_W.d, 1, 0.005);
  EXPECT_NEAR(votes.Highest()->area_m2, 1, 0.02);
}

TEST(HeightVotesTest, ARangeOfKilometresIsCutInTheMiddle) {
  HeightVotes votes;
  votes.Reset(-1e6, 1e6, 0.03);
  votes.Add(99, 1.0);
  votes.Add(500, 2.0);
  ASSERT_TRUE(votes.Highest());
  EXPECT_NEAR(votes.Highest()->plane_W.d, 99, 0.005);
}

}  // namespace
}  // namespace facet
