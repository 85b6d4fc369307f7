// SPDX-License-Identifier: BSD-2-Clause
// The calibration is estimated from simulated features: as exact as its covariance says, where the
// motion shows it, and left alone where it does not.
#include "facet/estimator/self_calibration.h"

#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "facet/calibration/drawn_calibration.h"
#include "facet/estimator/start/start_calibration.h"
#include "facet/estimator/vio_estimator.h"
#include "facet/geometry/angles.h"
#include "facet/sim/euroc_rig.h"
#include "facet/sim/feature_simulator.h"
#include "facet/testing/estimator/spoilt_run.h"

namespace facet {
namespace {

using Motion = std::function<void(std::vector<NavState>&)>;
// Changes what was written of the rig.
using Mistake = std::function<void(StereoRig&)>;

void AsFlown(std::vector<NavState>&) {}

void AtRest(std::vector<NavState>& poses) {
  for (NavState& pose : poses)
    pose.T_WB = poses.front().T_WB;
}

struct Calibrated {
  CalibrationVector error, sigma;  // of the refined calibration
  CalibrationVector error_before, sigma_before;
  bool are_modes_settled = false;
};

Calibrated Fly(
    const Motion& motion,
    std::uint64_t seed,
    double duration_s,
    const Mistake& mistake = [](StereoRig&) {},
    const Vector3d& gyro_scale = Vector3d::Zero(),
    const LensModeVector& lens_modes = LensModeVector::Zero()) {
  FeatureSimulatorOptions options;
  options.max_tracks = 70;
  options.duration_s = duration_s;
  std::vector<NavState> poses = MakeFlight(duration_s + 2, 2);
  motion(poses);
  StereoRig rig = EurocRig();
  rig.lens_modes = {lens_modes, -lens_modes};
  SimulatedRun run = SimulateFeatures(SplineTrajectory::Fit(poses), rig, options, seed);
  for (ImuSample& sample : run.imu)
    sample.gyro = sample.gyro.cwiseQuotient(Vector3d::Ones() - gyro_scale);
  run.rig.gyro_scale = gyro_scale;
  StereoRig written = *DrawCalibration(run.rig, seed);
  written.gyro_scale.setZero();
  mistake(written);
  const ImuBuffer imu = testing::ImuOf(run);
  VioEstimator estimator(written, ImuNoise{}, {});
  StageTimes times;
  Timestamp previous = run.frames.front().t + written.time_offset;
  for (const FrameObservations& frame : run.frames) {
    const Timestamp now = frame.t + written.time_offset;
    estimator.AddFrame(frame, imu.Between(previous, now, Duration{20'000'000}, Duration{0}), times);
    previous = now;
  }
  const auto refined = estimator.Calibration();
  EXPECT_TRUE(refined) << seed;
  if (!refined) return {};
  EXPECT_EQ(refined->axes_sigma, CalibrationOptions().AxesSigma());
  return {CalibrationDifference(run.rig, *refined),
          refined->covariance->diagonal().cwiseSqrt(),
          CalibrationDifference(run.rig, written),
          StartCovariance(written, {}).diagonal().cwiseSqrt(),
          estimator.window().calibration->are_modes_settled()};
}

TEST(CalibrationOptionsTest, AnImuThatIsTakenAsExactHasExactAxes) {
  CalibrationOptions options;
  EXPECT_NEAR(options.AxesSigma(), 0.05 * kDegree, 1e-12);
  options.gyro = false;
  EXPECT_EQ(options.AxesSigma(), 0);
}

double MeanSquare(const CalibrationVector& error, const CalibrationVector& sigma) {
  return error.cwiseQuotient(sigma).squaredNorm() / kNumCalibration;
}

TEST(SelfCalibrationTest, FindsWhatTheMotionShowsAndKnowsHowWell) {
  double nees = 0;
  constexpr int kNumSeeds = 6;
  for (int seed = 1; seed <= kNumSeeds; ++seed) {
    const Calibrated flown = Fly(AsFlown, static_cast<std::uint64_t>(seed), 20);
    nees += MeanSquare(flown.error, flown.sigma) / kNumSeeds;
    EXPECT_LT(std::abs(flown.error(kTimeOffset)), 1.2e-4) << seed;
    EXPECT_LT(flown.sigma(kTimeOffset), 2.5e-4);
    EXPECT_LT(MeanSquare(flown.error, flown.sigma_before),
              0.6 * MeanSquare(flown.error_before, flown.sigma_before) + 0.2)
        << seed;
  }
  EXPECT_GT(nees, 0.4);
  EXPECT_LT(nees, 1.8);
}

TEST(SelfCalibrationTest, AtRestNothingIsLearntThatCannotBeSeen) {
  double nees = 0;
  constexpr int kNumSeeds = 4;
  for (int seed = 1; seed <= kNumSeeds; ++seed) {
    const Calibrated flown = Fly(AtRest, static_cast<std::uint64_t>(seed), 40);
    nees += MeanSquare(flown.error, flown.sigma) / kNumSeeds;
    // Nothing tells the common focal length from the distances, nor the clock.
    EXPECT_GT(flown.sigma(0), 0.5 * flown.sigma_before(0)) << seed;
    EXPECT_GT(flown.sigma(kMountTranslation), 0.5 * flown.sigma_before(kMountTranslation)) << seed;
    EXPECT_GT(flown.sigma(kGyroScale), 0.9 * flown.sigma_before(kGyroScale)) << seed;
    EXPECT_LT(std::abs(flown.error(0) - flown.error_before(0)), 2.5 * flown.sigma_before(0));
  }
  EXPECT_LT(nees, 1.8);
}

TEST(SelfCalibrationTest, WhatLensesDoBesideTheirModelsIsFound) {
  LensModeVector modes;
  modes << 0.05, -0.04, 0.06, -0.05, 0.04, -0.06, 0.05, -0.04, 0.06, -0.05;
  const Calibrated flown = Fly(
      AsFlown, 3, 30, [](StereoRig&) {}, Vector3d::Zero(), modes);
  EXPECT_FALSE(flown.are_modes_settled);
  for (int c = 0; c < 2; ++c) {
    const LensModeVector error = LensModesOf(flown.error, c);
    const LensModeVector sigma = LensModesOf(flown.sigma, c);
    EXPECT_LT(error.norm(), 0.3 * modes.norm()) << c;
    EXPECT_LT(error.cwiseQuotient(sigma).squaredNorm() / kNumLensModes, 4) << c;
  }
}

TEST(SelfCalibrationTest, LensesThatFollowTheirModelsHaveModesThatSettle) {
  EXPECT_TRUE(Fly(AsFlown, 3, 40).are_modes_settled);
}

TEST(SelfCalibrationTest, AGyroscopeThatReadsTooMuchIsFound) {
  const Vector3d scale(0.005, -0.004, 0.006);
  const Calibrated flown = Fly(
      AsFlown, 2, 20, [](StereoRig&) {}, scale);
  EXPECT_LT(flown.error.tail<3>().norm(), 0.3 * scale.norm());
  EXPECT_LT(flown.error.tail<3>().cwiseQuotient(flown.sigma.tail<3>()).norm(), 4);
  EXPECT_LT(MeanSquare(flown.error, flown.sigma), 2.5);
}

TEST(SelfCalibrationTest, AClockThatIsFarOffIsFoundAndTheLensesAreLeftAlone) {
  for (const double offset : {-0.01, 0.01}) {
    const Calibrated flown = Fly(AsFlown, 1, 25, [&](StereoRig& written) {
      written.time_offset = written.time_offset + FromSeconds(offset);
    });
    EXPECT_LT(std::abs(flown.error(kTimeOffset)), 3e-4) << offset;
    // In which 1 % of the focal length would be freed.
    EXPECT_LT(flown.sigma(0), 1.2 * flown.sigma_before(0)) << offset;
    EXPECT_LT(std::abs(flown.error(0)), 3 * flown.sigma_before(0)) << offset;
  }
}

}  // namespace
}  // namespace facet
