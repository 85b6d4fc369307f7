// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/window/imu_intervals.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include "facet/testing/estimator/test_window.h"

namespace facet {
namespace {

using testing::TestMotion;

constexpr Duration kOffset{3'000'000};  // between the clocks of IMU and camera
constexpr double kStep_s = 0.1;         // between frames

// Perfect samples of a motion, which the IMU stamps by its own clock.
class ImuIntervalsTest : public ::testing::Test {
 protected:
  ImuIntervalsTest()
      : rng_(7), motion_(TestMotion::Random(rng_)), intervals_(ImuNoise{}, ImuOptions{}, kOffset) {
    intervals_.Begin(StampOf(0));
  }

  static Timestamp StampOf(double t) { return Timestamp{} + FromSeconds(t); }

  ImuInterval Samples(double t0, double t1) const {
    ImuInterval interval;
    const int n = static_cast<int>(std::lround((t1 - t0) * 200));
    for (int i = 0; i <= n; ++i) {
      interval.samples.push_back(motion_.ImuAt(t0 + i / 200.0, ImuBias{}));
      interval.samples.back().t = interval.samples.back().t + kOffset;
    }
    return interval;
  }

  PredictedFrame Next(double t, const ImuInterval& imu) {
    return intervals_.Next(motion_.At(t - kStep_s), std::nullopt, StampOf(t), imu);
  }

  Rng rng_;
  TestMotion motion_;
  ImuIntervals intervals_;
};

TEST_F(ImuIntervalsTest, TheNewFrameIsWhereTheSamplesLead) {
  for (const double t : {0.1, 0.2, 0.3}) {
    const PredictedFrame frame = Next(t, Samples(t - kStep_s, t));
    EXPECT_FALSE(frame.link.is_synthetic);
    EXPECT_EQ(frame.x.t, StampOf(t));
    EXPECT_NEAR(frame.link.measured.dt(), kStep_s, 1e-9);
    EXPECT_LT(testing::Difference(motion_.At(t), frame.x).norm(), 1e-3);
    EXPECT_EQ(frame.link.sqrt_info, ImuSqrtInfo(frame.link.measured, testing::DefaultBiasWalk()));
  }
}

TEST_F(ImuIntervalsTest, WithoutSamplesTheVelocityStaysAndLittleIsKnown) {
  const PredictedFrame seen = Next(0.1, Samples(0, 0.1));
  intervals_.Begin(StampOf(0));
  const PredictedFrame invented = Next(0.1, ImuInterval{});
  EXPECT_TRUE(invented.link.is_synthetic);
  const NavState last = motion_.At(0);
  EXPECT_LT((invented.x.v_WB - last.v_WB).norm(), 1e-9);
  EXPECT_LT((invented.x.T_WB.p - last.T_WB.p - kStep_s * last.v_WB).norm(), 1e-9);
  EXPECT_LT(invented.x.T_WB.q.angularDistance(last.T_WB.q), 1e-9);
  const auto sigma_v = [](const PredictedFrame& frame) {
    return std::sqrt(frame.link.measured.Covariance()(8, 8));
  };
  EXPECT_GT(sigma_v(invented), 100 * sigma_v(seen));
}

TEST_F(ImuIntervalsTest, SamplesThatMakeNoSenseAreAsGoodAsNone) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::function<void(std::vector<ImuSample>&)>> mischief = {
      [](auto& samples) { samples.resize(1); },
      [](auto& samples) { std::reverse(samples.begin(), samples.end()); },
      [](auto& samples) { std::swap(samples[3], samples[4]); },
      [](auto& samples) { samples.erase(samples.begin()); },      // begins too late
      [](auto& samples) { samples.resize(samples.size() - 4); },  // ends too early
      [](auto& samples) { samples[2].gyro.x() = kNan; },
      [](auto& samples) { samples[2].accel.z() = std::numeric_limits<double>::infinity(); },
  };
  for (const auto& spoil : mischief) {
    ImuInterval imu = Samples(0, 0.1);
    spoil(imu.samples);
    intervals_.Begin(StampOf(0));
    EXPECT_TRUE(Next(0.1, imu).link.is_synthetic);
  }
}

TEST_F(ImuIntervalsTest, AHoleMakesTheIntervalLessCertain) {
  ImuInterval imu = Samples(0, 0.1);
  const Matrix<9, 9> without = Next(0.1, imu).link.measured.Covariance();
  imu.has_hole = true;
  intervals_.Begin(StampOf(0));
  const Matrix<9, 9> with = Next(0.1, imu).link.measured.Covariance();
  EXPECT_LT((with - 100 * without).norm(), 1e-6 * with.norm());
}

TEST_F(ImuIntervalsTest, AnIntervalBeginsWhereTheOneBeforeEnded) {
  ImuInterval longer = Samples(0, 0.105);
  EXPECT_FALSE(Next(0.1, longer).link.is_synthetic) << "nearly to the frame is good enough";
  const PredictedFrame next = Next(0.2, Samples(0.105, 0.2));
  EXPECT_FALSE(next.link.is_synthetic);
  EXPECT_NEAR(next.link.measured.dt(), 0.095, 1e-9);
  // Also after one that was made up.
  EXPECT_TRUE(Next(0.3, ImuInterval{}).link.is_synthetic);
  EXPECT_FALSE(Next(0.4, Samples(0.3, 0.4)).link.is_synthetic);
}

TEST_F(ImuIntervalsTest, TheLinkOfAPassingFrameGoesOn) {
  PredictedFrame passing = Next(0.1, Samples(0, 0.1));
  const ImuLink at_once = [&] {
    ImuIntervals other(ImuNoise{}, ImuOptions{}, kOffset);
    other.Begin(StampOf(0));
    return other.Next(motion_.At(0), std::nullopt, StampOf(0.2), Samples(0, 0.2)).link;
  }();
  const NavState middle = passing.x;
  const PredictedFrame frame =
      intervals_.Next(middle, std::move(passing.link), StampOf(0.2), Samples(0.1, 0.2));
  const ImuPreintegration &joined = frame.link.measured, &expected = at_once.measured;
  EXPECT_LT((joined.dp() - expected.dp()).norm(), 1e-12);
  EXPECT_LT((joined.Covariance() - expected.Covariance()).norm(),
            1e-9 * expected.Covariance().norm());
  EXPECT_LT(testing::Difference(motion_.At(0.2), frame.x).norm(), 1e-3);
}

TEST_F(ImuIntervalsTest, AfterAPassingFrameNoImuMakesItUncertain) {
  PredictedFrame passing = Next(0.1, Samples(0, 0.1));
  const NavState middle = passing.x;
  const PredictedFrame frame =
      intervals_.Next(middle, std::move(passing.link), StampOf(0.2), ImuInterval{});
  EXPECT_TRUE(frame.link.is_synthetic);
  EXPECT_NEAR(frame.link.measured.dt(), 0.2, 1e-9);
  EXPECT_GT(std::sqrt(frame.link.measured.Covariance()(8, 8)), 1.0);  // m/s
}

// What happened while there were no samples stays unknown, whatever comes after it.
TEST_F(ImuIntervalsTest, AnOutageStaysUncertainWhenSamplesComeAgain) {
  PredictedFrame outage = Next(0.1, ImuInterval{});
  const double sigma_angle = std::sqrt(outage.link.measured.Covariance()(0, 0));
  const NavState middle = outage.x;
  ImuInterval with_hole = Samples(0.1, 0.2);
  with_hole.has_hole = true;
  const PredictedFrame frame =
      intervals_.Next(middle, std::move(outage.link), StampOf(0.2), with_hole);
  EXPECT_GT(std::sqrt(frame.link.measured.Covariance()(0, 0)), 0.9 * sigma_angle);

  const PredictedFrame next = Next(0.3, Samples(0.2, 0.3));
  const ImuLink joined = intervals_.Join(frame.link, next.link);
  EXPECT_GT(std::sqrt(joined.measured.Covariance()(0, 0)), 0.9 * sigma_angle);
}

TEST_F(ImuIntervalsTest, WhatIsAHoleIsSaidByTheBuffer) {
  ImuInterval slow;
  for (const double t : {0.0, 0.025, 0.05, 0.075, 0.1}) {
    slow.samples.push_back(motion_.ImuAt(t, ImuBias{}));
    slow.samples.back().t = slow.samples.back().t + kOffset;
  }
  slow.allowed_gap = FromSeconds(0.04);
  const double usual = std::sqrt(Next(0.1, slow).link.measured.Covariance()(0, 0));
  intervals_.Begin(StampOf(0));
  slow.allowed_gap = FromSeconds(0.02);
  EXPECT_GT(std::sqrt(Next(0.1, slow).link.measured.Covariance()(0, 0)), 10 * usual);
}

TEST_F(ImuIntervalsTest, JoinedIntervalsAreOne) {
  const PredictedFrame first = Next(0.1, Samples(0, 0.1));
  const PredictedFrame second = Next(0.2, Samples(0.1, 0.2));
  const ImuLink joined = intervals_.Join(first.link, second.link);
  ImuPreintegration expected = first.link.measured;
  expected.Append(second.link.measured);
  EXPECT_EQ(joined.measured.dv(), expected.dv());
  EXPECT_EQ(joined.sqrt_info, ImuSqrtInfo(expected, testing::DefaultBiasWalk()));
}

TEST_F(ImuIntervalsTest, LinksAreIntegratedAgainWhenTheirBiasHasMoved) {
  SlidingWindow window;
  window.frames.resize(3);
  for (int j : {1, 2})
    window.frames[j].imu_link = Next(j * kStep_s, Samples((j - 1) * kStep_s, j * kStep_s)).link;
  window.frames[0].x.bias.b_g = Vector3d(1e-3, 0, 0);  // little
  window.frames[1].x.bias.b_g = Vector3d(1e-2, 0, 0);
  const ImuLink before = *window.frames[1].imu_link;
  intervals_.Relinearize(window);
  EXPECT_EQ(window.frames[1].imu_link->measured.dp(), before.measured.dp());
  const ImuLink& after = *window.frames[2].imu_link;
  EXPECT_EQ(after.measured.bias().b_g, window.frames[1].x.bias.b_g);
  EXPECT_EQ(after.sqrt_info, ImuSqrtInfo(after.measured, testing::DefaultBiasWalk()));
}

}  // namespace
}  // namespace facet
