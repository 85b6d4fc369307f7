// SPDX-License-Identifier: BSD-2-Clause
// Simulated stereo features: the rig moves as it did in truth, as far as the calibration goes.
#include "facet/plausibility/stereo_motion.h"

#include <gtest/gtest.h>

#include "facet/base/median.h"
#include "facet/geometry/angles.h"
#include "facet/geometry/so3.h"
#include "facet/sim/euroc_rig.h"
#include "facet/sim/feature_simulator.h"

namespace facet {
namespace {

constexpr std::size_t kFramesPerKeyframe = 4;

SimulatedRun Fly(std::uint64_t seed, double outlier_share = 0.02) {
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
    if (i % kFramesPerKeyframe != 0) continue;
    const SE3 now = motion.AddKeyframe(run.frames[i]), true_now = run.truth[i].T_WB;
    if (motion.IsAtBeginning()) {
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
    StepErrors errors = Follow(Fly(seed), EurocRig());
    EXPECT_EQ(errors.num_beginnings, 1) << seed;
    EXPECT_LT(*Median(errors.m), 0.006) << seed;
    EXPECT_LT(*Median(errors.rad), 0.1 * kDegree) << seed;
  }
}

// A tenth of all left and of all right places: one pair of four is wrong.
TEST(StereoMotionTest, ManyPairsMayBeWrong) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    StepErrors errors = Follow(Fly(seed, 0.1), EurocRig());
    EXPECT_GT(errors.num_steps, 40) << seed;
    EXPECT_LT(*Median(errors.m), 0.012) << seed;
  }
}

// Pixels and the gyroscope are as before; the rig is said to be half as wide again.
TEST(StereoMotionTest, StepsAreAsLongAsTheBaselineSays) {
  StereoRig rig = EurocRig();
  rig.T_BC[1].p = rig.T_BC[0].p + 1.5 * (rig.T_BC[1].p - rig.T_BC[0].p);
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const SimulatedRun run = Fly(seed);
    StepErrors as_said = Follow(run, rig, 1.5), as_in_truth = Follow(run, rig, 1);
    EXPECT_LT(*Median(as_said.m), 0.02) << seed;
    EXPECT_GT(*Median(as_in_truth.m), 0.03) << seed;
  }
}

TEST(StereoMotionTest, WhatCannotBeComparedIsABeginning) {
  const SimulatedRun run = Fly(1);
  StereoMotion motion(run.rig);
  motion.AddKeyframe(run.frames[0]);
  EXPECT_TRUE(motion.IsAtBeginning());
  motion.AddKeyframe(run.frames[4]);
  EXPECT_FALSE(motion.IsAtBeginning());
  ASSERT_TRUE(motion.turn());

  ImuInterval hole;
  hole.has_hole = true;
  motion.AddImu(hole, Vector3d::Zero());
  EXPECT_TRUE(motion.IsAtBeginning());
  motion.AddKeyframe(run.frames[8]);
  EXPECT_TRUE(motion.IsAtBeginning());
  EXPECT_FALSE(motion.turn());

  FrameObservations few = run.frames[12];
  few.features.resize(10);
  motion.AddKeyframe(few);
  EXPECT_TRUE(motion.IsAtBeginning());
  motion.AddKeyframe(FrameObservations());
  EXPECT_TRUE(motion.IsAtBeginning());
}

}  // namespace
}  // namespace facet
