// SPDX-License-Identifier: BSD-2-Clause
#include "facet/eval/trajectory_error.h"

#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/base/check.h"
#include "facet/base/random.h"
#include "facet/geometry/so3.h"

namespace facet {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

StampedPose PoseAt(double t_s, const Vector3d& p, const Quaterniond& q = Quaterniond::Identity()) {
  return {Timestamp{FromSeconds(t_s).ns}, SE3(q, p)};
}

StampedPose StampAt(double t_s) {
  return PoseAt(t_s, Vector3d::Zero());
}

// A walk whose positions span all three dimensions.
std::vector<StampedPose> Walk(int num_poses) {
  std::vector<StampedPose> poses;
  for (int i = 0; i < num_poses; ++i) {
    const double a = 0.1 * i;
    const Vector3d p(std::cos(a) + 0.05 * i, 2 * std::sin(0.7 * a), 0.3 * std::sin(2.3 * a));
    poses.push_back(PoseAt(0.05 * i, p, ExpSO3({0.2 * std::sin(a), 0.3 * std::cos(a), a})));
  }
  return poses;
}

// The walk seen from another world frame, with a scale.
std::vector<StampedPose> Moved(const std::vector<StampedPose>& poses, const SE3& T, double scale) {
  std::vector<StampedPose> moved = poses;
  for (StampedPose& pose : moved) {
    pose.T_WB = {T.q * pose.T_WB.q, T * (scale * pose.T_WB.p)};
  }
  return moved;
}

std::vector<Vector3d> Positions(const std::vector<StampedPose>& poses) {
  std::vector<Vector3d> points;
  points.reserve(poses.size());
  for (const StampedPose& pose : poses) {
    points.push_back(pose.T_WB.p);
  }
  return points;
}

TEST(TrajectoryAlignmentTest, RecoversTheMotionThatWasApplied) {
  Rng rng(1);
  const auto truth = Walk(50);
  for (int i = 0; i < 20; ++i) {
    const Vector3d turn = 3.0 * rng.UnitVector();
    const Vector3d yaw_only(0, 0, rng.Uniform(-3, 3));
    const double scale = rng.Uniform(0.5, 2);
    const auto expect_aligned = [&](AlignmentKind kind, const SE3& T_WG, double s) {
      const auto p_W = Positions(Moved(truth, T_WG, s));
      const auto p_G = Positions(truth);
      const TrajectoryAlignment alignment = AlignTrajectory(p_W, p_G, kind);
      EXPECT_NEAR(alignment.scale, 1 / s, 1e-12);
      EXPECT_LT(LogSO3(alignment.T_GW.q * T_WG.q).norm(), 1e-7);
      for (std::size_t k = 0; k < p_G.size(); ++k) {
        EXPECT_LT((alignment * p_W[k] - p_G[k]).norm(), 1e-12);
      }
    };
    expect_aligned(AlignmentKind::kSE3, SE3(ExpSO3(turn), 10 * rng.Normal3()), 1);
    expect_aligned(AlignmentKind::kYawOnly, SE3(ExpSO3(yaw_only), 10 * rng.Normal3()), 1);
    expect_aligned(AlignmentKind::kSim3, SE3(ExpSO3(turn), 10 * rng.Normal3()), scale);
  }
}

TEST(TrajectoryAlignmentTest, NeverMirrors) {
  // The mirror image of a flat trajectory would fit perfectly.
  std::vector<Vector3d> flat, mirrored;
  for (int i = 0; i < 8; ++i) {
    flat.emplace_back(i, (i % 3) * 0.5, 0);
    mirrored.emplace_back(i, -(i % 3) * 0.5, 0);
  }
  const TrajectoryAlignment alignment = AlignTrajectory(flat, mirrored, AlignmentKind::kSE3);
  EXPECT_NEAR(alignment.T_GW.R().determinant(), 1, 1e-12);
  EXPECT_LT((alignment * flat[4] - mirrored[4]).norm(), 1e-12);  // by turning it over
}

TEST(TrajectoryAlignmentTest, StandingStillKeepsScaleOne) {
  const std::vector<Vector3d> still(5, Vector3d(1, 2, 3));
  const TrajectoryAlignment alignment = AlignTrajectory(still, still, AlignmentKind::kSim3);
  EXPECT_EQ(alignment.scale, 1);
  EXPECT_LT((alignment * still[0] - still[0]).norm(), 1e-12);
}

TEST(TrajectoryAlignmentTest, KindsHaveNames) {
  for (AlignmentKind kind : {AlignmentKind::kSE3, AlignmentKind::kYawOnly, AlignmentKind::kSim3}) {
    EXPECT_EQ(AlignmentKindFromText(ToString(kind)), kind);
  }
  EXPECT_FALSE(AlignmentKindFromText("affine"));
}

TEST(AssociateTest, InterpolatesPositionLinearlyAndRotationBySlerp) {
  const std::vector<StampedPose> truth = {PoseAt(10.0, {0, 0, 0}),
                                          PoseAt(10.08, {0.8, 0, 1.6}, ExpSO3({0, 0, 0.4}))};
  const std::vector<StampedPose> estimate = {StampAt(10.0), StampAt(10.02), StampAt(10.08)};
  const Association association = Associate(estimate, truth);
  ASSERT_EQ(association.pairs.size(), 3u);
  EXPECT_EQ(association.pairs[0].T_GB.p, truth[0].T_WB.p);
  EXPECT_EQ(association.pairs[2].T_GB.p, truth[1].T_WB.p);
  EXPECT_LT((association.pairs[1].T_GB.p - Vector3d(0.2, 0, 0.4)).norm(), 1e-12);
  EXPECT_LT((LogSO3(association.pairs[1].T_GB.q) - Vector3d(0, 0, 0.1)).norm(), 1e-12);
}

TEST(AssociateTest, NeverExtrapolatesNorBridgesHoles) {
  std::vector<StampedPose> truth;
  for (int i = 0; i < 100; ++i) {
    if (i < 40 || i >= 70) truth.push_back(PoseAt(1 + 0.01 * i, {0.1 * i, 0, 0}));
  }
  const std::vector<StampedPose> estimate = {
      StampAt(0.9), StampAt(1.105), StampAt(1.5), StampAt(1.6), StampAt(1.9), StampAt(2.0)};
  const Association association = Associate(estimate, truth);
  EXPECT_EQ(association.pairs.size(), 2u);
  EXPECT_EQ(association.num_outside, 2);
  EXPECT_EQ(association.num_in_gaps, 2);
}

TEST(StatisticsTest, MatchHandComputation) {
  const ErrorStatistics even = Summarize({4, 1, 3, 2});
  EXPECT_DOUBLE_EQ(even.median, 2.5);
  EXPECT_DOUBLE_EQ(even.mean, 2.5);
  EXPECT_DOUBLE_EQ(even.rmse, std::sqrt(7.5));
  EXPECT_DOUBLE_EQ(even.max, 4);
  EXPECT_DOUBLE_EQ(Summarize({5, 1, 3}).median, 3);
  EXPECT_THROW(Summarize({}), CheckError);
}

TEST(TrajectoryErrorTest, AteOfASquareWithBentCornersIsTheBend) {
  // Up and down in turn at the corners of a square: no rigid motion reduces that error.
  const double bend = 0.07;
  std::vector<StampedPose> truth, estimate;
  for (int i = 0; i < 40; ++i) {
    const double a = i * std::numbers::pi / 2;
    const Vector3d corner(std::round(std::cos(a)), std::round(std::sin(a)), 0);
    truth.push_back(PoseAt(0.1 * i, corner));
    estimate.push_back(PoseAt(0.1 * i, corner + Vector3d(0, 0, i % 2 == 0 ? bend : -bend)));
  }
  const SE3 T_WG(ExpSO3({0.3, -1, 2}), {5, 6, 7});
  const TrajectoryError error = EvaluateTrajectory(Moved(estimate, T_WG, 1), truth);
  EXPECT_EQ(error.num_pairs, 40);
  EXPECT_NEAR(error.ate_m.rmse, bend, 1e-12);
  EXPECT_NEAR(error.ate_m.median, bend, 1e-12);
  EXPECT_NEAR(error.ate_m.mean, bend, 1e-12);
  EXPECT_NEAR(error.ate_m.max, bend, 1e-12);
}

TEST(TrajectoryErrorTest, ScaleErrorOnAStraightLine) {
  // 2 % too long on a straight line of 100 m: closed forms for every figure.
  std::vector<StampedPose> truth, estimate;
  for (int i = 0; i <= 1000; ++i) {
    truth.push_back(PoseAt(0.05 * i, {0.1 * i, 0, 0}));
    estimate.push_back(PoseAt(0.05 * i, {0, 0.102 * i, 0}, ExpSO3({0, 0, std::numbers::pi / 2})));
  }
  const TrajectoryError error = EvaluateTrajectory(estimate, truth);
  EXPECT_NEAR(error.path_length_m, 100, 1e-9);
  EXPECT_NEAR(error.ate_m.max, 0.02 * 50, 1e-9);
  EXPECT_NEAR(error.ate_m.rmse, 0.02 * 0.1 * std::sqrt((1001.0 * 1001.0 - 1) / 12), 1e-9);
  ASSERT_EQ(error.rpe.size(), 8u);
  EXPECT_EQ(error.rpe[3].length_m, 10);
  EXPECT_EQ(error.rpe[3].translation_m.size(), 901u);
  EXPECT_NEAR(Summarize(error.rpe[3].translation_m).median, 0.2, 1e-9);
  EXPECT_NEAR(Summarize(error.rpe[3].rotation_rad).max, 0, 1e-9);
  // Not exact: near the end the closest pair may be up to 1 % shorter than the nominal length.
  EXPECT_NEAR(*error.drift_percent, 2, 1e-3);
  EXPECT_NEAR(*error.scale_error_percent, 2, 1e-9);
  const TrajectoryError with_scale =
      EvaluateTrajectory(estimate, truth, {AlignmentKind::kSim3, {}});
  EXPECT_NEAR(with_scale.ate_m.max, 0, 1e-9);
}

TEST(TrajectoryErrorTest, HeadingDriftIsTheRotationError) {
  // The heading drifts by 0.01 rad per metre of path.
  std::vector<StampedPose> truth, estimate;
  for (int i = 0; i <= 600; ++i) {
    const Vector3d p(0.05 * i, 0, 0);
    truth.push_back(PoseAt(0.05 * i, p));
    estimate.push_back(PoseAt(0.05 * i, p, ExpSO3({0, 0, 0.01 * p.x()})));
  }
  const TrajectoryError error = EvaluateTrajectory(estimate, truth, {AlignmentKind::kSE3, {5}});
  ASSERT_EQ(error.rpe.size(), 1u);
  const ErrorStatistics rotation = Summarize(error.rpe[0].rotation_rad);
  EXPECT_NEAR(rotation.median, 0.05, 1e-9);
  EXPECT_NEAR(rotation.rmse, 0.05, 1e-9);
}

TEST(TrajectoryErrorTest, RelativeErrorsTakeTheClosestPairWithinOnePercent) {
  // Steps of 0.3 m: 1 m is met by no pair (0.9 and 1.2 m), 3 m by every pair ten steps apart.
  std::vector<PosePair> pairs;
  for (int i = 0; i < 31; ++i) {
    const SE3 pose(Quaterniond::Identity(), {0.3 * i, 0, 0});
    pairs.push_back({Timestamp{i}, pose, pose});
  }
  EXPECT_THAT(ComputeRelativeErrors(pairs, 1).translation_m, IsEmpty());
  EXPECT_EQ(ComputeRelativeErrors(pairs, 1, 0.11).translation_m.size(), 28u);
  EXPECT_EQ(ComputeRelativeErrors(pairs, 3).translation_m.size(), 21u);
  EXPECT_THAT(ComputeRelativeErrors(pairs, 20).translation_m, IsEmpty());
}

TEST(TrajectoryErrorTest, StandingStillHasNoDriftAndNoScale) {
  std::vector<StampedPose> still;
  for (int i = 0; i < 10; ++i) {
    still.push_back(PoseAt(i, {1, 2, 3}));
  }
  const TrajectoryError error = EvaluateTrajectory(still, still);
  EXPECT_NEAR(error.ate_m.max, 0, 1e-12);
  EXPECT_FALSE(error.drift_percent);
  EXPECT_FALSE(error.scale_error_percent);
}

TEST(TrajectoryErrorTest, DefaultLengthsFollowThePath) {
  EXPECT_THAT(DefaultRpeLengths(5.5), ElementsAre(1, 2, 5));
  EXPECT_THAT(DefaultRpeLengths(76), ElementsAre(1, 2, 5, 10, 20, 30, 40, 50));
  EXPECT_THAT(DefaultRpeLengths(0.4), ElementsAre(0.1, 0.2));
  EXPECT_THAT(DefaultRpeLengths(0), IsEmpty());
}

TEST(WhatIsWrongTest, SaysWhyTrajectoriesCannotBeCompared) {
  const auto truth = Walk(50);
  EXPECT_EQ(WhatIsWrong(truth, truth), "");
  EXPECT_THAT(WhatIsWrong({}, truth), HasSubstr("no pose"));
  EXPECT_THAT(WhatIsWrong(truth, {}), HasSubstr("no pose"));
  EXPECT_THAT(WhatIsWrong(std::span(truth).first(2), truth), HasSubstr("at least 3"));
  EXPECT_THAT(WhatIsWrong(truth, std::span(truth).first(2)), HasSubstr("only 2 of 50"));

  auto other_day = truth;
  for (StampedPose& pose : other_day) {
    pose.t = pose.t + FromSeconds(86400);
  }
  EXPECT_THAT(WhatIsWrong(other_day, truth), HasSubstr("no overlap"));
  EXPECT_THROW(EvaluateTrajectory(other_day, truth), CheckError);
}

TEST(WhatIsWrongTest, RecognisesStampsInAnotherUnit) {
  std::vector<StampedPose> ns, us;
  for (int i = 0; i < 5; ++i) {
    const std::int64_t stamp = 1403636584763555584 + 50'000'000LL * i;
    ns.push_back({Timestamp{stamp}, SE3()});
    us.push_back({Timestamp{stamp / 1000}, SE3()});
  }
  EXPECT_THAT(WhatIsWrong(us, ns), HasSubstr("another unit of time"));
}

}  // namespace
}  // namespace facet
