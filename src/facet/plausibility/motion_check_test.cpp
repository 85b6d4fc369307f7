// SPDX-License-Identifier: BSD-2-Clause
// Simulated features and IMU against calibrations that are right and wrong. States are asked for
// nothing but the gyroscope's bias where the test says so.
#include "facet/plausibility/motion_check.h"

#include <gtest/gtest.h>

#include "facet/geometry/so3.h"
#include "facet/sim/euroc_rig.h"
#include "facet/sim/feature_simulator.h"
#include "facet/testing/wrong_rigs.h"

namespace facet {
namespace {

constexpr std::size_t kFramesPerKeyframe = 4;

SimulatedRun FlyFor(std::uint64_t seed, double duration_s) {
  FeatureSimulatorOptions options;
  options.pixel_sigma = 0.1;
  options.outlier_share = 0.02;
  options.duration_s = duration_s;
  return SimulateFeatures(
      SplineTrajectory::Fit(MakeFlight(duration_s, seed)), EurocRig(), options, seed);
}

/// Hands the IMU of a flight to the check, and calls visit(i) at each frame.
template <class Visit>
void VisitFrames(const SimulatedRun& run, MotionCheck& check, const Visit& visit) {
  ImuBuffer imu;
  for (const ImuSample& sample : run.imu)
    imu.Add(sample);
  for (std::size_t i = 0; i < run.frames.size(); ++i) {
    if (i > 0)
      check.AddImu(
          imu.Between(run.truth[i - 1].t, run.truth[i].t, Duration{21'000'000}, Duration{0}));
    visit(i);
  }
}

struct Judgement {
  bool is_doubted = false, is_refused = false, are_turns_doubted = false;
  std::string negated_axes;
  std::optional<ScaleCheck::Scale> scale;
};

// The estimator has one state and then none, so that all is by the images. What the axes of the
// accelerometer and of the gyroscope are multiplied with: `axes`, `gyro_axes`.
Judgement Judge(const SimulatedRun& run,
                const StereoRig& rig,
                const Vector3d& axes = Vector3d::Ones(),
                const Vector3d& gyro_axes = Vector3d::Ones()) {
  ImuBuffer imu;
  for (ImuSample sample : run.imu) {
    sample.accel = sample.accel.cwiseProduct(axes);
    sample.gyro = sample.gyro.cwiseProduct(gyro_axes);
    imu.Add(sample);
  }
  MotionCheck check(rig);
  Judgement out;
  for (std::size_t i = 0; i < run.frames.size(); ++i) {
    if (i > 0) {
      check.AddImu(
          imu.Between(run.truth[i - 1].t, run.truth[i].t, Duration{21'000'000}, Duration{0}));
      check.LoseState();
    }
    if (i % kFramesPerKeyframe != 0) continue;
    const ScaleCheck::Finding finding =
        check.AddKeyframe(run.frames[i], i == 0 ? run.truth.data() : nullptr);
    out.is_doubted |= finding == ScaleCheck::Finding::kDoubt;
    out.is_refused |= finding == ScaleCheck::Finding::kRefusal;
    if (finding == ScaleCheck::Finding::kAxesTheOtherWay)
      out.negated_axes = check.found_by().negated_axes();
    out.are_turns_doubted |= check.TakeDoubtOfTurns().has_value();
  }
  out.scale = check.scale();
  return out;
}

StereoRig WithBaseline(double factor) {
  return testing::WithBaseline(EurocRig(), factor);
}

StereoRig WithFocalLengths(double factor) {
  return testing::WithFocalLengths(EurocRig(), factor);
}

TEST(MotionCheckTest, TheRightCalibrationIsNeitherDoubtedNorRefused) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Judgement judgement = Judge(FlyFor(seed, 40), EurocRig());
    EXPECT_FALSE(judgement.is_doubted || judgement.is_refused) << seed;
    EXPECT_FALSE(judgement.are_turns_doubted) << seed;
    EXPECT_EQ(judgement.negated_axes, "") << seed;
    ASSERT_TRUE(judgement.scale) << seed;
    EXPECT_LT(std::abs(judgement.scale->value() - 1), 0.02) << seed;
  }
}

TEST(MotionCheckTest, ADoubledBaselineIsRefusedWithoutAnyEstimator) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const SimulatedRun run = FlyFor(seed, 15);
    EXPECT_TRUE(Judge(run, WithBaseline(2)).is_refused) << seed;
    EXPECT_TRUE(Judge(run, WithBaseline(0.5)).is_refused) << seed;
  }
}

TEST(MotionCheckTest, ABaselineThatIsOffByTwoPerCentIsDoubted) {
  int num_doubted = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const Judgement judgement = Judge(FlyFor(seed, 30), WithBaseline(1.02));
    num_doubted += judgement.is_doubted ? 1 : 0;
    EXPECT_FALSE(judgement.is_refused) << seed;
    EXPECT_FALSE(judgement.are_turns_doubted) << seed;
  }
  EXPECT_GE(num_doubted, 7);
}

// Of the error of the focal lengths a third to all is seen in turns, translations take the rest.
TEST(MotionCheckTest, FocalLengthsThatAreOffByTwoPerCentAreDoubted) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const SimulatedRun run = FlyFor(seed, 20);
    EXPECT_TRUE(Judge(run, WithFocalLengths(1.02)).are_turns_doubted) << seed;
    EXPECT_TRUE(Judge(run, WithFocalLengths(0.98)).are_turns_doubted) << seed;
  }
}

TEST(MotionCheckTest, ANegatedAxisOfTheAccelerometerIsNamedWithoutAnyEstimator) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const SimulatedRun run = FlyFor(seed, 15);
    EXPECT_EQ(Judge(run, EurocRig(), Vector3d(-1, 1, 1)).negated_axes, "x") << seed;
    EXPECT_EQ(Judge(run, EurocRig(), Vector3d(1, 1, -1)).negated_axes, "z") << seed;
  }
}

// Of an IMU whose axes are all wrong the gyroscope is to be named, which another check does.
TEST(MotionCheckTest, WithAWrongGyroscopeTheAccelerometerIsNotBlamedSoon) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const SimulatedRun run = FlyFor(seed, 10);
    const Vector3d axes(1, -1, 1);
    EXPECT_EQ(Judge(run, EurocRig(), axes).negated_axes, "y") << seed;
    EXPECT_EQ(Judge(run, EurocRig(), axes, axes).negated_axes, "") << seed;
  }
}

// Nothing is seen for half a second while the body turns.
TEST(MotionCheckTest, ABreakInTheImagesTakesNothingAway) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SimulatedRun run = FlyFor(seed, 20);
    const std::size_t begin = 4 * (run.frames.size() / 12);
    for (std::size_t i = begin; i < begin + 10; ++i)
      run.frames[i].features.clear();
    EXPECT_TRUE(Judge(run, WithBaseline(2)).is_refused) << seed;
    const Judgement right = Judge(run, EurocRig());
    ASSERT_TRUE(right.scale) << seed;
    EXPECT_NEAR(right.scale->value(), 1, 0.02) << seed;
    EXPECT_EQ(right.negated_axes, "") << seed;
  }
}

// A former run has found that the gyroscope reads ten per cent too much.
TEST(MotionCheckTest, AStatedScaleOfTheGyroscopeIsTakenOut) {
  StereoRig rig = EurocRig();
  rig.gyro_scale = Vector3d::Constant(0.1);
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SimulatedRun run = FlyFor(seed, 20);
    // reading - scale reading - bias = rate, as everywhere.
    for (ImuSample& sample : run.imu)
      sample.gyro /= 0.9;
    const Judgement judgement = Judge(run, rig);
    EXPECT_FALSE(judgement.are_turns_doubted || judgement.is_doubted) << seed;
    EXPECT_TRUE(Judge(run, EurocRig()).are_turns_doubted) << seed;
  }
}

// A car that accelerates on a truck, or a lift: nothing moves in the images.
TEST(MotionCheckTest, ImagesThatDoNotMoveAreNoWrongSize) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SimulatedRun run = FlyFor(seed, 30);
    Rng rng(seed);
    for (FrameObservations& frame : run.frames) {
      const FrameId id = frame.frame;
      frame = run.frames.front();
      frame.frame = id;
      for (FeatureObservation& feature : frame.features)
        feature.px_left += 0.1 * rng.Normal3().head<2>();
    }
    const Judgement judgement = Judge(run, EurocRig());
    EXPECT_FALSE(judgement.is_refused || judgement.is_doubted) << seed;
    EXPECT_FALSE(judgement.are_turns_doubted) << seed;
  }
}

// The estimator has believed the accelerometer, the images have not.
TEST(MotionCheckTest, WhereStatesContradictTheImagesTheImagesCount) {
  const SimulatedRun run = FlyFor(1, 30);
  MotionCheck check(WithBaseline(1.05));
  int num_doubts = 0;
  VisitFrames(run, check, [&](std::size_t i) {
    if (i % kFramesPerKeyframe != 0) return;
    const auto finding = check.AddKeyframe(run.frames[i], &run.truth[i]);
    num_doubts += finding == ScaleCheck::Finding::kDoubt ? 1 : 0;
  });
  EXPECT_EQ(num_doubts, 1);
  ASSERT_TRUE(check.scale());
  EXPECT_NEAR(check.scale()->value(), 1.05, 0.02);
  EXPECT_NEAR(check.found_by().scale()->value(), 1.05, 0.02);
  EXPECT_FALSE(check.SetRig(WithBaseline(1.051))) << "too little to change the size";
  check.WorldHasChanged();
  EXPECT_FALSE(check.scale());
  EXPECT_FALSE(check.turns()) << "of the given calibration only";
}

// The estimator finds the baseline; what was measured with the wrong one counts no more.
TEST(MotionCheckTest, ALearntBaselineBeginsAnew) {
  const SimulatedRun run = FlyFor(1, 30);
  MotionCheck check(WithBaseline(1.05));
  std::optional<double> before;
  VisitFrames(run, check, [&](std::size_t i) {
    check.LoseState();
    if (i == run.frames.size() / 2) {
      ASSERT_TRUE(check.scale());
      before = check.scale()->value();
      EXPECT_TRUE(check.SetRig(EurocRig()));
      EXPECT_FALSE(check.scale());
    }
    if (i % kFramesPerKeyframe == 0)
      check.AddKeyframe(run.frames[i], i == 0 ? run.truth.data() : nullptr);
  });
  ASSERT_TRUE(before);
  EXPECT_NEAR(*before, 1.05, 0.02);
  ASSERT_TRUE(check.scale());
  EXPECT_NEAR(check.scale()->value(), 1, 0.02);
}

// In the middle of turns, too: gravity is where it was.
TEST(MotionCheckTest, WhenTheWorldChangesOrientationsStayComparable) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const SimulatedRun run = FlyFor(seed, 30);
    MotionCheck check(EurocRig());
    VisitFrames(run, check, [&](std::size_t i) {
      check.LoseState();
      if (i < 400 && i % 97 == 50) check.WorldHasChanged();
      if (i % kFramesPerKeyframe != 0) return;
      const auto finding = check.AddKeyframe(run.frames[i], i == 0 ? run.truth.data() : nullptr);
      EXPECT_EQ(finding, ScaleCheck::Finding::kNothing) << seed;
      EXPECT_EQ(check.found_by().negated_axes(), "") << seed;
    });
    ASSERT_TRUE(check.scale()) << seed;
    EXPECT_NEAR(check.scale()->value(), 1, 0.02) << seed;
  }
}

// That the estimator gives parts of the calibration room, or changes it by little, does not make
// good what is wrong beyond hope, and does not put off that it is said.
TEST(MotionCheckTest, WhatIsHopelessIsNotMeasuredAnew) {
  const SimulatedRun run = FlyFor(1, 12);
  MotionCheck check(WithBaseline(2));
  bool has_changed = false, is_refused = false;
  VisitFrames(run, check, [&](std::size_t i) {
    if (is_refused) return;
    check.LoseState();
    if (check.scale() && !has_changed) {
      has_changed = true;
      check.WorldHasChanged();
      EXPECT_TRUE(check.SetRig(WithBaseline(2.02)));
      EXPECT_TRUE(check.scale());
    }
    if (i % kFramesPerKeyframe != 0) return;
    const auto finding = check.AddKeyframe(run.frames[i], i == 0 ? run.truth.data() : nullptr);
    is_refused = finding == ScaleCheck::Finding::kRefusal;
  });
  EXPECT_TRUE(has_changed);
  EXPECT_TRUE(is_refused);
}

}  // namespace
}  // namespace facet
