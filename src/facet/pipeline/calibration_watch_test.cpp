// SPDX-License-Identifier: BSD-2-Clause
// Made-up evidence, and that of the estimator on simulated features with a calibration that is
// wrong and one that is right.
#include "facet/pipeline/calibration_watch.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/estimator/vio_estimator.h"
#include "facet/sim/euroc_rig.h"
#include "facet/sim/feature_simulator.h"

namespace facet {
namespace {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Keyframes five times a second.
class Keyframes {
 public:
  void Add(double seconds, const CalibrationEvidence& evidence) {
    for (int i = 0; i < std::lround(5 * seconds); ++i) {
      CalibrationEvidence now = evidence;
      now.t = t_;
      t_ = t_ + Duration{200'000'000};
      const std::string warning = watch_.Add(now);
      if (!warning.empty()) warnings_.push_back(warning);
    }
  }
  void Pause(double seconds) { t_ = t_ + FromSeconds(seconds); }
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  CalibrationWatch watch_;
  Timestamp t_{1'400'000'000'000'000'000};
  std::vector<std::string> warnings_;
};

const CalibrationEvidence kGood{{}, 100, 60, 1.0, {}};
const CalibrationEvidence kOneEye{{}, 100, 2, 1.0, {}};
const CalibrationEvidence kWrongImu{{}, 100, 60, 30.0, {}};

TEST(CalibrationWatchTest, SaysNothingOfGoodKeyframes) {
  Keyframes keyframes;
  keyframes.Add(60, kGood);
  EXPECT_THAT(keyframes.warnings(), IsEmpty());
}

TEST(CalibrationWatchTest, WarnsOnceWhenTheRightImageNeverMatches) {
  Keyframes keyframes;
  keyframes.Add(60, kOneEye);
  EXPECT_THAT(keyframes.warnings(),
              ElementsAre(AllOf(HasSubstr("only 2 % of the corners"), HasSubstr("swapped"))));
}

TEST(CalibrationWatchTest, WhatWasRightIsNotCalledSwapped) {
  Keyframes keyframes;
  keyframes.Add(10, kGood);
  keyframes.Add(10, kOneEye);
  EXPECT_THAT(
      keyframes.warnings(),
      ElementsAre(AllOf(
          HasSubstr("only 2 % of the corners"), HasSubstr("knocked"), Not(HasSubstr("swapped")))));
}

TEST(CalibrationWatchTest, WarnsOnceWhenTheImuNeverFits) {
  Keyframes keyframes;
  keyframes.Add(60, kWrongImu);
  EXPECT_THAT(keyframes.warnings(),
              ElementsAre(AllOf(HasSubstr("by 30 times"), HasSubstr("timeshift_cam_imu"))));
}

TEST(CalibrationWatchTest, WarnsAgainWhenItComesAgainLater) {
  Keyframes keyframes;
  keyframes.Add(10, kOneEye);
  keyframes.Add(60, kGood);
  keyframes.Add(10, kWrongImu);
  keyframes.Add(20, kGood);
  keyframes.Add(10, kWrongImu);
  keyframes.Add(60, kGood);
  keyframes.Add(10, kOneEye);
  EXPECT_THAT(keyframes.warnings(),
              ElementsAre(HasSubstr("right image"), HasSubstr("IMU"), HasSubstr("right image")));
}

TEST(CalibrationWatchTest, NamesTheImagesWhenBothAreWrong) {
  Keyframes keyframes;
  keyframes.Add(60, {{}, 100, 0, kInfinity, {}});
  EXPECT_THAT(keyframes.warnings(), ElementsAre(HasSubstr("right image")));
}

TEST(CalibrationWatchTest, EstimatorThatNeverStartsLeavesTheImages) {
  Keyframes keyframes;
  keyframes.Add(60, {{}, 100, 0, std::nullopt, {}});
  EXPECT_THAT(keyframes.warnings(), ElementsAre(HasSubstr("right image")));
}

TEST(CalibrationWatchTest, TwoBadSecondsAreNoReason) {
  Keyframes keyframes;
  for (int i = 0; i < 5; ++i) {
    keyframes.Add(2, kOneEye);
    keyframes.Add(4, kGood);
    keyframes.Add(1, {{}, 100, 60, kInfinity, {}});
    keyframes.Add(4, kGood);
  }
  EXPECT_THAT(keyframes.warnings(), IsEmpty());
}

TEST(CalibrationWatchTest, ABreakEndsAStretch) {
  Keyframes keyframes;
  for (int i = 0; i < 5; ++i) {
    keyframes.Add(2, kWrongImu);
    keyframes.Pause(10);
  }
  EXPECT_THAT(keyframes.warnings(), IsEmpty());
}

TEST(CalibrationWatchTest, EstimatorThatIsSoonLostAgain) {
  Keyframes keyframes;
  for (int i = 0; i < 5; ++i) {
    keyframes.Add(2, kWrongImu);
    keyframes.Pause(2);
  }
  EXPECT_THAT(keyframes.warnings(), ElementsAre(HasSubstr("IMU")));
}

TEST(CalibrationWatchTest, MissingRightImagesAndBlankWallsAreNoEvidence) {
  Keyframes keyframes;
  keyframes.Add(60, {{}, 100, std::nullopt, 1.0, {}});
  keyframes.Add(60, {{}, 5, 0, 1.0, {}});
  EXPECT_THAT(keyframes.warnings(), IsEmpty());
}

// Warnings while the estimator runs with another time offset than the simulated one.
std::vector<std::string> WarningsWithOffset(Duration error, const CalibrationOptions& estimated) {
  FeatureSimulatorOptions options;
  options.max_tracks = 70;
  options.duration_s = 20;
  const SimulatedRun run =
      SimulateFeatures(SplineTrajectory::Fit(MakeFlight(10, 2)), EurocRig(), options, 1);
  ImuBuffer buffer;
  for (const ImuSample& sample : run.imu)
    buffer.Add(sample);
  StereoRig rig = run.rig;
  rig.time_offset = rig.time_offset + error;
  EstimatorOptions estimator_options;
  estimator_options.calibration = estimated;
  VioEstimator estimator(rig, ImuNoise{}, estimator_options);
  CalibrationWatch watch;
  StageTimes times;
  std::vector<std::string> warnings;
  Timestamp previous = run.frames.front().t + rig.time_offset;
  for (const FrameObservations& frame : run.frames) {
    const Timestamp now = frame.t + rig.time_offset;
    const ImuInterval imu = buffer.Between(previous, now, Duration{20'000'000}, Duration{0});
    previous = now;
    const EstimatorResult result = estimator.AddFrame(frame, imu, times);
    if (!frame.is_keyframe) continue;
    const std::string warning =
        watch.Add({frame.t, 70, 70, result.imu_error_sigma, estimator.GrossDeviations()});
    if (!warning.empty()) warnings.push_back(warning);
  }
  return warnings;
}

TEST(CalibrationWatchTest, TimeOffsetOnSimulatedFeatures) {
  const auto held = CalibrationOptions::Held();
  EXPECT_THAT(WarningsWithOffset(Duration{0}, held), IsEmpty());
  EXPECT_THAT(WarningsWithOffset(Duration{40'000'000}, held),
              ElementsAre(HasSubstr("time offset")));
  EXPECT_THAT(WarningsWithOffset(Duration{-40'000'000}, held),
              ElementsAre(HasSubstr("time offset")));
}

TEST(CalibrationWatchTest, AnEstimatedTimeOffsetIsNamedWithItsSize) {
  EXPECT_THAT(WarningsWithOffset(Duration{1'000'000}, {}), IsEmpty());
  EXPECT_THAT(WarningsWithOffset(Duration{20'000'000}, {}),
              ElementsAre(ContainsRegex("time offset -(18|19|20) ms")));
  EXPECT_THAT(WarningsWithOffset(Duration{-20'000'000}, {}),
              ElementsAre(ContainsRegex("time offset [+](18|19|20) ms")));
}

TEST(CalibrationWatchTest, WhatTheEstimatorHasFoundIsNamedOnceAndAgainWithWhatComesLater) {
  const CalibrationDeviation clock{CalibrationPart::kClock, "time offset", "ms", -10, 0.1, 1};
  const CalibrationDeviation mount{
      CalibrationPart::kMount, "cameras on the IMU about x", "deg", 0.5, 0.01, 0.1};
  Keyframes keyframes;
  CalibrationEvidence evidence = kGood;
  keyframes.Add(10, evidence);
  evidence.gross_deviations = {clock};
  keyframes.Add(10, evidence);
  evidence.gross_deviations = {mount, clock};
  keyframes.Add(10, evidence);
  evidence.gross_deviations = {mount};
  keyframes.Add(10, evidence);
  EXPECT_THAT(keyframes.warnings(),
              ElementsAre(HasSubstr("one is: time offset -10 ms; this"),
                          HasSubstr("about x +0.5 deg, time offset -10 ms; this")));
}

}  // namespace
}  // namespace facet
