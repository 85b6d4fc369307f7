// SPDX-License-Identifier: BSD-2-Clause
// Simulated stereo features: the rig moves as it did in truth, as far as the calibration goes.
#include "facet/plausibility/stereo_motion.h"

#include <optional>

#include <gtest/gtest.h>

#include "facet/base/median.h"
#include "facet/geometry/angles.h"
#include "facet/geometry/so3.h"
#include "facet/sim/euroc_rig.h"
#include "facet/sim/feature_simulator.h"
#include "facet/testing/wrong_rigs.h"

namespace facet {
namespace {

constexpr std::size_t kFramesApart = 4;

SimulatedRun FlyWithOutliers(std::uint64_t seed, double outlier_share = 0.02) {
  FeatureSimulatorOptions options;
  options.pixel_sigma = 0.1;
  options.outlier_share = outlier_share;
  options.duration_s = 10;
  return SimulateFeatures(SplineTrajectory::Fit(MakeFlight(10, seed)), EurocRig(), options, seed);
}

struct StepErrors {
  std::vector<double> m, rad;  // of the steps from keyframe to keyframe
  int num_steps = 0, num_beginnings = 0;
};

// `size`: of the steps that are expected.
StepErrors Follow(const SimulatedRun& run, const StereoRig& rig, double size = 1) {
  ImuBuffer imu;
  for (const ImuSample& sample : run.imu)
    imu.Add(sample);
  StereoMotion motion(rig);
  StepErrors errors;
  SE3 before, true_before;
  for (std::size_t i = 0; i < run.frames.size(); ++i) {
    if (i > 0) {
      motion.AddImu(
          imu.Between(run.truth[i - 1].t, run.truth[i].t, Duration{21'000'000}, Duration{0}),
          run.truth[i].bias.b_g);
    }
    if (i % kFramesApart != 0) continue;
    const SE3 now = motion.AddKeyframe(run.frames[i]), true_now = run.truth[i].T_WB;
    if (!motion.turn()) {
      ++errors.num_beginnings;
    } else {
      const SE3 step = before.Inverse() * now, truth = true_before.Inverse() * true_now;
      errors.m.push_back((step.p - size * truth.p).norm());
      errors.rad.push_back(LogSO3(step.q.conjugate() * truth.q).norm());
      ++errors.num_steps;
    }
    before = now;
    true_before = true_now;
  }
  return errors;
}

TEST(StereoMotionTest, MovesAsTheRigDid) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    StepErrors errors = Follow(FlyWithOutliers(seed), EurocRig());
    EXPECT_EQ(errors.num_beginnings, 1) << seed;
    EXPECT_LT(*Median(errors.m), 0.006) << seed;
    EXPECT_LT(*Median(errors.rad), 0.1 * kDegree) << seed;
  }
}

// A tenth of all left and of all right places: one pair of four is wrong.
TEST(StereoMotionTest, ManyPairsMayBeWrong) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    StepErrors errors = Follow(FlyWithOutliers(seed, 0.1), EurocRig());
    EXPECT_GT(errors.num_steps, 40) << seed;
    EXPECT_LT(*Median(errors.m), 0.012) << seed;
  }
}

// Pixels and the gyroscope are as before; the rig is said to be half as wide again.
TEST(StereoMotionTest, StepsAreAsLongAsTheBaselineSays) {
  const StereoRig rig = testing::WithBaseline(EurocRig(), 1.5);
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const SimulatedRun run = FlyWithOutliers(seed);
    StepErrors as_said = Follow(run, rig, 1.5), as_in_truth = Follow(run, rig, 1);
    EXPECT_LT(*Median(as_said.m), 0.02) << seed;
    EXPECT_GT(*Median(as_in_truth.m), 0.03) << seed;
  }
}

// Just before a keyframe, when the rig has turned since the one before.
TEST(StereoMotionTest, WhenPointsAreForgottenOrientationsGoOn) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const SimulatedRun run = FlyWithOutliers(seed);
    ImuBuffer imu;
    for (const ImuSample& sample : run.imu)
      imu.Add(sample);
    StereoMotion motion(run.rig);
    std::optional<Quaterniond> first;
    for (std::size_t i = 0; i <= 160; ++i) {
      if (i > 0)
        motion.AddImu(
            imu.Between(run.truth[i - 1].t, run.truth[i].t, Duration{21'000'000}, Duration{0}),
            run.truth[i].bias.b_g);
      if (i % 20 == 0) motion.ForgetPoints();
      if (i % kFramesApart != 0) continue;
      const Quaterniond from_truth =
          motion.AddKeyframe(run.frames[i]).q * run.truth[i].T_WB.q.conjugate();
      EXPECT_FALSE(motion.HasLostOrientation() && i > 0) << seed;
      if (!first) first = from_truth;
      EXPECT_LT(LogSO3(first->conjugate() * from_truth).norm(), 0.7 * kDegree) << seed << ' ' << i;
    }
  }
}

TEST(StereoMotionTest, WhereImagesCannotBeComparedTheGyroscopeGoesOn) {
  const SimulatedRun run = FlyWithOutliers(1);
  ImuBuffer imu;
  for (const ImuSample& sample : run.imu)
    imu.Add(sample);
  StereoMotion motion(run.rig);
  SE3 first, last;
  for (std::size_t i = 0; i <= 40; ++i) {
    if (i > 0)
      motion.AddImu(
          imu.Between(run.truth[i - 1].t, run.truth[i].t, Duration{21'000'000}, Duration{0}),
          run.truth[i].bias.b_g);
    if (i % kFramesApart != 0) continue;
    FrameObservations seen = run.frames[i];
    const bool is_dark = i == 16 || i == 20;
    if (is_dark) seen.features.resize(i == 16 ? 10 : 0);
    last = motion.AddKeyframe(seen);
    if (i == 0) first = last;
    const bool can_be_compared = i > 0 && !is_dark && i != 24;
    EXPECT_EQ(motion.turn().has_value(), can_be_compared) << i;
    EXPECT_FALSE(motion.HasLostOrientation());
  }
  const SE3 turned = first.Inverse() * last;
  const SE3 truth = run.truth[0].T_WB.Inverse() * run.truth[40].T_WB;
  EXPECT_GT(LogSO3(truth.q).norm(), 0.2);
  EXPECT_LT(LogSO3(turned.q.conjugate() * truth.q).norm(), 0.5 * kDegree);
}

TEST(StereoMotionTest, WithoutImagesAHoleOfTheImuLosesTheOrientation) {
  const SimulatedRun run = FlyWithOutliers(1);
  StereoMotion motion(run.rig);
  motion.AddKeyframe(run.frames[0]);
  ImuInterval hole;
  hole.has_hole = true;
  motion.AddImu(hole, Vector3d::Zero());
  motion.AddKeyframe(run.frames[4]);
  EXPECT_FALSE(motion.HasLostOrientation()) << "the images know it";
  EXPECT_FALSE(motion.turn()) << "with nothing to compare them with";
  motion.AddImu(hole, Vector3d::Zero());
  motion.AddKeyframe(FrameObservations());
  EXPECT_TRUE(motion.HasLostOrientation());
}

// Distances that are hardly known make motions too short; the farthest points are left out.
TEST(StereoMotionTest, FarAwayStepsAreNotTooShort) {
  FeatureSimulatorOptions options;
  options.pixel_sigma = 0.3;
  options.duration_s = 20;
  options.room = {.min_margin_m = 8, .max_margin_m = 12, .num_boxes = 0, .num_boards = 0};
  double sum = 0, true_sum = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const SimulatedRun run =
        SimulateFeatures(SplineTrajectory::Fit(MakeFlight(20, seed)), EurocRig(), options, seed);
    StereoMotion motion(run.rig);
    SE3 before, true_before;
    for (std::size_t i = 0; i < run.frames.size(); i += kFramesApart) {
      const SE3 now = motion.AddKeyframe(run.frames[i]), true_now = run.truth[i].T_WB;
      if (motion.turn()) {
        const Vector3d truth = (true_before.Inverse() * true_now).p;
        sum += (before.Inverse() * now).p.dot(truth);
        true_sum += truth.squaredNorm();
      }
      before = now;
      true_before = true_now;
    }
  }
  ASSERT_GT(true_sum, 0.1);
  EXPECT_NEAR(sum / true_sum, 1, 0.01);
}

}  // namespace
}  // namespace facet
