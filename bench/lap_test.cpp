// SPDX-License-Identifier: BSD-2-Clause
#include "bench/lap.h"

#include <gtest/gtest.h>

#include "facet/geometry/so3.h"
#include "facet/io/errors.h"

namespace facet {
namespace {

constexpr Duration kFrameStep{50'000'000};
constexpr Duration kImuStep{5'000'000};

struct Recording {
  std::vector<Timestamp> frames;
  std::vector<ImuSample> imu;
  std::vector<NavState> truth;
};

/// Once around a circle of 1 m in a second, with a gyroscope whose bias drifts.
Recording Circle(double turns) {
  Recording recording;
  for (int i = 0; i < 20; ++i)
    recording.frames.push_back({i * kFrameStep.ns});
  for (int i = -10; i < 210; ++i) {
    const Timestamp t{i * kImuStep.ns};
    const double rate = 2 * M_PI * turns, angle = rate * ToSeconds(t - Timestamp{});
    NavState state;
    state.t = t;
    state.T_WB.p = {std::cos(angle), std::sin(angle), 0};
    state.v_WB = rate * Vector3d(-std::sin(angle), std::cos(angle), 0);
    state.bias.b_g.x() = 1e-3 * i;
    recording.truth.push_back(state);
    recording.imu.push_back({t, {0.5 + state.bias.b_g.x(), 0, 0}, {9.81, 0, 0}});
  }
  return recording;
}

Lap LapOf(const Recording& recording) {
  return {recording.frames, recording.imu, recording.truth};
}

TEST(LapTest, LapsOfTwoTakesHaveTheSameBias) {
  const Lap first = LapOf(Circle(1));
  Recording other = Circle(1);
  for (NavState& state : other.truth)
    state.bias.b_a.z() = 0.25;
  for (ImuSample& sample : other.imu)
    sample.accel.z() += 0.25;
  const Lap second(other.frames, other.imu, other.truth, first.bias());
  const std::vector<ImuSample> expected = first.ImuOf(1), samples = second.ImuOf(1);
  ASSERT_EQ(samples.size(), expected.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    EXPECT_TRUE(samples[i].gyro.isApprox(expected[i].gyro, 1e-12)) << i;
    EXPECT_TRUE(samples[i].accel.isApprox(expected[i].accel, 1e-12)) << i;
  }
}

TEST(LapTest, NextLapGoesOnWithoutAHole) {
  const Lap lap = LapOf(Circle(1));
  EXPECT_EQ(lap.period().ns, 20 * kFrameStep.ns);
  EXPECT_EQ((lap.FrameStamp(1, 0) - lap.FrameStamp(0, lap.num_frames() - 1)).ns, kFrameStep.ns);
  const std::vector<ImuSample> first = lap.ImuOf(0), third = lap.ImuOf(2), fourth = lap.ImuOf(3);
  EXPECT_EQ(first.size(), 200u);
  EXPECT_EQ(first.front().t, lap.FrameStamp(0, 0));
  EXPECT_EQ((fourth.front().t - third.back().t).ns, kImuStep.ns);
}

TEST(LapTest, BiasesDoNotJumpWhereTheLapBeginsAgain) {
  const Lap lap = LapOf(Circle(1));
  for (const ImuSample& sample : lap.ImuOf(1))
    EXPECT_NEAR(sample.gyro.x(), 0.5, 1e-12);
}

TEST(LapTest, RefusesAMotionThatDoesNotReturn) {
  EXPECT_THROW(LapOf(Circle(0.7)), InputError);
}

TEST(LapTest, TakesAFastTurnThatGoesOn) {
  Recording recording = Circle(1);
  for (NavState& state : recording.truth)
    state.T_WB.q = ExpSO3({0, 0, 2 * M_PI * ToSeconds(state.t - Timestamp{})});
  EXPECT_NO_THROW(LapOf(recording));
  for (NavState& state : recording.truth)
    state.T_WB.q = ExpSO3({0, 0, 0.9 * 2 * M_PI * ToSeconds(state.t - Timestamp{})});
  EXPECT_THROW(LapOf(recording), InputError);
}

TEST(LapTest, RefusesATruthWithoutBiases) {
  Recording recording = Circle(1);
  for (NavState& state : recording.truth)
    state.bias.b_a.setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_THROW(LapOf(recording), InputError);
}

}  // namespace
}  // namespace facet
