// SPDX-License-Identifier: BSD-2-Clause
// States of made-up flights with the errors that keyframes have, in a world of another size.
#include "facet/plausibility/scale_check.h"

#include <optional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/geometry/so3.h"
#include "facet/sim/euroc_rig.h"
#include "facet/sim/feature_simulator.h"

namespace facet {
namespace {

using ::testing::HasSubstr;

constexpr double kPositionSigma_m = 0.001, kRotationSigma = 0.0005;
constexpr std::size_t kFramesPerKeyframe = 4;
// The world of the images is not level with that of the truth.
const SE3 kTilt(ExpSO3(Vector3d(0.02, -0.03, 0.5)), Vector3d(1, 2, 3));

struct Judgement {
  bool is_doubted = false, is_refused = false;
  std::optional<ScaleCheck::Scale> scale;
  std::string negated_axes;
};

// `early_size`: of the first `early_s` seconds. `axes`: what those of the accelerometer are
// multiplied with. `told_s`: that the size changes is told so long before; empty: as a break.
Judgement Fly(std::uint64_t seed,
              double size,
              double duration_s,
              double early_size = 1,
              double early_s = 0,
              const Vector3d& axes = Vector3d::Ones(),
              std::optional<double> told_s = std::nullopt,
              bool is_distrusted = false) {
  FeatureSimulatorOptions options;
  options.max_tracks = 1;
  options.duration_s = duration_s;
  const SimulatedRun run = SimulateFeatures(
      SplineTrajectory::Fit(MakeFlight(duration_s, seed)), EurocRig(), options, seed);
  ImuBuffer imu;
  for (ImuSample sample : run.imu) {
    sample.accel = sample.accel.cwiseProduct(axes);
    imu.Add(sample);
  }
  Rng rng(seed);
  ScaleCheck check;
  if (is_distrusted) check.DistrustAccelerometer();
  Judgement out;
  bool was_early = false, is_told = false;
  for (std::size_t i = 1; i < run.truth.size(); ++i) {
    check.AddImu(
        imu.Between(run.truth[i - 1].t, run.truth[i].t, Duration{21'000'000}, Duration{0}));
    if (i % kFramesPerKeyframe != 0) continue;
    NavState state = run.truth[i];
    const Duration flown = state.t - run.truth[0].t;
    const bool is_early = flown < FromSeconds(early_s);
    if (early_s > 0 && told_s && !is_told && flown >= FromSeconds(early_s - *told_s)) {
      check.WorldHasChanged(FromSeconds(1));
      is_told = true;
    }
    if (was_early && !is_early && !told_s) check.Break();
    was_early = is_early;
    state.T_WB.p = (is_early ? early_size : size) * state.T_WB.p + kPositionSigma_m * rng.Normal3();
    state.T_WB.q = state.T_WB.q * ExpSO3(kRotationSigma * rng.Normal3());
    state.T_WB = kTilt * state.T_WB;
    const ScaleCheck::Finding finding = check.AddKeyframe(state);
    out.is_doubted |= finding == ScaleCheck::Finding::kDoubt;
    out.is_refused |= finding == ScaleCheck::Finding::kRefusal;
    if (finding == ScaleCheck::Finding::kAxesTheOtherWay && out.negated_axes.empty())
      out.negated_axes = check.negated_axes();
  }
  out.scale = check.scale();
  return out;
}

TEST(ScaleCheckTest, TheSizeOfTheWorldIsFoundWithinItsSigma) {
  double sum = 0;
  constexpr int kRuns = 12;
  for (int seed = 0; seed < kRuns; ++seed) {
    const double size = seed % 3 == 0 ? 1.0 : 1.05;
    const Judgement judgement = Fly(static_cast<std::uint64_t>(seed), size, 30);
    ASSERT_TRUE(judgement.scale);
    sum += std::pow((judgement.scale->value() - size) / judgement.scale->sigma, 2);
    EXPECT_LT(judgement.scale->sigma, 0.01) << seed;
  }
  // The sigma allows for errors of neighbours that white ones do not have.
  EXPECT_GT(sum / kRuns, 0.01);
  EXPECT_LT(sum / kRuns, 1.5);
}

TEST(ScaleCheckTest, ARightCalibrationIsNotDoubted) {
  for (std::uint64_t seed = 20; seed < 40; ++seed) {
    const Judgement judgement = Fly(seed, 1.003, 60);
    EXPECT_FALSE(judgement.is_doubted || judgement.is_refused) << seed;
  }
}

// The first seconds of a run are less settled than what follows.
TEST(ScaleCheckTest, ADoubtHasToLast) {
  int num_short = 0, num_long = 0;
  for (std::uint64_t seed = 20; seed < 30; ++seed) {
    num_short += Fly(seed, 1.003, 60, 1.04, 4.5).is_doubted ? 1 : 0;
    num_long += Fly(seed, 1.003, 60, 1.04, 25).is_doubted ? 1 : 0;
  }
  EXPECT_EQ(num_short, 0);
  EXPECT_GE(num_long, 9);
}

TEST(ScaleCheckTest, AWrongBaselineIsDoubtedAndADoubledOneRefused) {
  for (std::uint64_t seed = 40; seed < 50; ++seed) {
    const Judgement wrong = Fly(seed, 0.94, 40);
    EXPECT_TRUE(wrong.is_doubted) << seed;
    EXPECT_FALSE(wrong.is_refused) << seed;
    EXPECT_TRUE(Fly(seed, 2, 20).is_refused) << seed;
    EXPECT_TRUE(Fly(seed, 0.5, 20).is_refused) << seed;
  }
}

// The estimator then holds the world upside down, and all accelerations are the wrong way round.
TEST(ScaleCheckTest, AnAccelerometerWithTheWrongSignIsRefused) {
  for (std::uint64_t seed = 60; seed < 65; ++seed)
    EXPECT_EQ(Fly(seed, -1, 20).negated_axes, "xyz") << seed;
}

TEST(ScaleCheckTest, NegatedAxesOfTheAccelerometerAreNamed) {
  const std::pair<Vector3d, const char*> cases[] = {
      {{-1, 1, 1}, "x"}, {{1, -1, 1}, "y"}, {{1, 1, -1}, "z"}, {{-1, 1, -1}, "xz"}};
  for (std::uint64_t seed = 70; seed < 75; ++seed) {
    for (const auto& [axes, name] : cases)
      EXPECT_EQ(Fly(seed, 1, 20, 1, 0, axes).negated_axes, name) << seed;
  }
}

// Slow flights, whose accelerations drown in the errors of the poses, and wrong sizes.
TEST(ScaleCheckTest, NoAxisIsCalledNegatedWithoutReason) {
  for (std::uint64_t seed = 80; seed < 100; ++seed)
    EXPECT_EQ(Fly(seed, seed % 2 == 0 ? 1.0 : 0.7, 60).negated_axes, "") << seed;
}

// An accelerometer that breaks later is no wrong calibration.
TEST(ScaleCheckTest, WhatWasRightOnceIsNotRefused) {
  for (std::uint64_t seed = 40; seed < 43; ++seed) {
    EXPECT_TRUE(Fly(seed, 2, 30).is_refused) << seed;
    EXPECT_FALSE(Fly(seed, 2, 30, 1, 10).is_refused) << seed;
  }
}

// The size is wrong for the first seconds only, and the accelerometer may be to blame for it.
TEST(ScaleCheckTest, WhatADistrustedAccelerometerSaysOnceIsNoReasonToRefuse) {
  int num_trusted = 0;
  for (std::uint64_t seed = 40; seed < 46; ++seed) {
    num_trusted += Fly(seed, 1, 30, 1.25, 4.2).is_refused ? 1 : 0;
    EXPECT_FALSE(Fly(seed, 1, 30, 1.25, 4.2, Vector3d::Ones(), {}, true).is_refused) << seed;
    EXPECT_TRUE(Fly(seed, 2, 20, 1, 0, Vector3d::Ones(), {}, true).is_refused) << seed;
  }
  EXPECT_GE(num_trusted, 5);
}

// The first half is a world of another size; only what follows the change counts.
TEST(ScaleCheckTest, AfterTheWorldHasChangedItsSizeIsMeasuredAnew) {
  const Judgement both = Fly(30, 1, 40, 1.1, 20);
  const Judgement anew = Fly(30, 1, 40, 1.1, 20, Vector3d::Ones(), 0.0);
  ASSERT_TRUE(both.scale && anew.scale);
  EXPECT_GT(both.scale->value(), 1.03);
  EXPECT_NEAR(anew.scale->value(), 1, 0.01);
}

// Poses jump to where they belong in the changed world after that was told.
TEST(ScaleCheckTest, WhatHappensWhileTheWorldChangesIsLeftOut) {
  for (std::uint64_t seed = 100; seed < 110; ++seed) {
    const Judgement judgement = Fly(seed, 1, 11, 2, 5, Vector3d::Ones(), 0.5);
    ASSERT_TRUE(judgement.scale) << seed;
    EXPECT_NEAR(judgement.scale->value(), 1, 0.02) << seed;
    EXPECT_EQ(judgement.negated_axes, "") << seed;
  }
}

TEST(ScaleCheckTest, ABodyAtRestSaysNothing) {
  ScaleCheck check;
  Rng rng(5);
  Timestamp t{1'400'000'000'000'000'000};
  for (int k = 0; k < 600; ++k) {
    ImuInterval interval;
    for (int i = 0; i <= 40; ++i) {
      interval.samples.push_back({t + Duration{5'000'000 * i},
                                  0.002 * rng.Normal3(),
                                  Vector3d(0, 0, kGravity) + 0.03 * rng.Normal3()});
    }
    t = interval.samples.back().t;
    check.AddImu(interval);
    NavState state;
    state.t = t;
    state.T_WB.p = 0.0005 * rng.Normal3();
    EXPECT_EQ(check.AddKeyframe(state), ScaleCheck::Finding::kNothing) << k;
  }
}

TEST(ScaleCheckTest, PosesOnBothSidesOfABreakAreNotCompared) {
  ScaleCheck check;
  Timestamp t{1'400'000'000'000'000'000};
  for (int k = 0; k < 100; ++k) {
    ImuInterval interval;
    for (int i = 0; i <= 40; ++i)
      interval.samples.push_back(
          {t + Duration{5'000'000 * i}, Vector3d::Zero(), Vector3d(0, 0, kGravity)});
    t = interval.samples.back().t;
    check.AddImu(interval);
    NavState state;
    state.t = t;
    state.T_WB.p = Vector3d(k, 0, 0);
    check.AddKeyframe(state);
    check.Break();
  }
  EXPECT_FALSE(check.scale());
}

TEST(ScaleCheckTest, SaysWhatToLookAt) {
  EXPECT_THAT(InWords(ScaleCheck::Scale{1.02, 1.022, 0.004}),
              HasSubstr("2.1 % (1-sigma 0.4) too large"));
  EXPECT_THAT(InWords(ScaleCheck::Scale{0.5, 0.5, 0.05}),
              HasSubstr("50.0 % (1-sigma 5.0) too small"));
  EXPECT_THAT(InWords(ScaleCheck::Scale{-1.2, -0.9, 0.05}), HasSubstr("+9.8 upwards"));
  EXPECT_THAT(NegatedAxesInWords("y"), HasSubstr("an axis of the accelerometer, y, shows the opp"));
  EXPECT_THAT(NegatedAxesInWords("xz"), HasSubstr("accelerometer, x and z, show the opp"));
  EXPECT_THAT(NegatedAxesInWords("xyz"), HasSubstr("the accelerometer shows the opp"));
}

}  // namespace
}  // namespace facet
