// SPDX-License-Identifier: BSD-2-Clause
#include "facet/imu/imu_buffer.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace facet {
namespace {

constexpr Duration kMaxGap{20'000'000};
constexpr Duration kMaxExtrapolation{10'000'000};

Timestamp Ms(double ms) {
  return {std::llround(ms * 1e6)};
}

ImuSample Sample(double ms) {
  return {Ms(ms), 1e-3 * Vector3d(ms, 2 * ms, -ms), Vector3d(1 + 1e-3 * ms, 0, 9.81)};
}

ImuBuffer EveryFiveMs(int count) {
  ImuBuffer buffer;
  for (int i = 0; i < count; ++i)
    buffer.Add(Sample(5.0 * i));
  return buffer;
}

ImuInterval Between(const ImuBuffer& buffer, double ms0, double ms1) {
  return buffer.Between(Ms(ms0), Ms(ms1), kMaxGap, kMaxExtrapolation);
}

TEST(ImuBufferTest, InterpolatesAtBothEnds) {
  const ImuInterval interval = Between(EveryFiveMs(10), 7, 21.5);
  ASSERT_EQ(interval.samples.size(), 5u);  // 7 10 15 20 21.5
  EXPECT_EQ(interval.samples.front().t, Ms(7));
  EXPECT_EQ(interval.samples.back().t, Ms(21.5));
  for (const ImuSample& s : interval.samples) {
    const ImuSample expected = Sample(static_cast<double>(s.t.ns) * 1e-6);
    EXPECT_LT((s.gyro - expected.gyro).norm(), 1e-12);
    EXPECT_LT((s.accel - expected.accel).norm(), 1e-12);
  }
  EXPECT_EQ(interval.gaps, 0);
  EXPECT_EQ(interval.longest_gap, Duration{5'000'000});
}

TEST(ImuBufferTest, UsesSamplesThatLieExactlyAtTheEnds) {
  const ImuInterval interval = Between(EveryFiveMs(10), 10, 20);
  ASSERT_EQ(interval.samples.size(), 3u);
  EXPECT_EQ(interval.samples[0].gyro, Sample(10).gyro);
  EXPECT_EQ(interval.samples[2].gyro, Sample(20).gyro);
}

TEST(ImuBufferTest, NeighbouringIntervalsShareTheirEndSample) {
  const ImuBuffer buffer = EveryFiveMs(10);
  const ImuSample end = Between(buffer, 3, 17).samples.back();
  const ImuSample start = Between(buffer, 17, 33).samples.front();
  EXPECT_EQ(end.t, start.t);
  EXPECT_EQ(end.gyro, start.gyro);
  EXPECT_EQ(end.accel, start.accel);
}

TEST(ImuBufferTest, AnIntervalBetweenTwoSamplesHasTwo) {
  const ImuInterval interval = Between(EveryFiveMs(10), 11, 13);
  ASSERT_EQ(interval.samples.size(), 2u);
  EXPECT_NEAR(interval.samples[0].gyro.x(), 0.011, 1e-12);
  EXPECT_NEAR(interval.samples[1].gyro.x(), 0.013, 1e-12);
}

TEST(ImuBufferTest, AnEmptyIntervalHasOne) {
  EXPECT_EQ(Between(EveryFiveMs(10), 12, 12).samples.size(), 1u);
  EXPECT_EQ(Between(EveryFiveMs(10), 10, 10).samples.size(), 1u);
}

TEST(ImuBufferTest, HoldsTheLastSampleForAShortTime) {
  const ImuBuffer buffer = EveryFiveMs(10);  // up to 45 ms
  const ImuInterval held = Between(buffer, 38, 55);
  ASSERT_EQ(held.samples.size(), 4u);  // 38 40 45 55
  EXPECT_EQ(held.samples[3].t, Ms(55));
  EXPECT_EQ(held.samples[3].gyro, Sample(45).gyro);
  EXPECT_TRUE(Between(buffer, 38, 55.1).samples.empty());
  EXPECT_EQ(Between(buffer, 47, 52).samples.size(), 2u);
}

TEST(ImuBufferTest, RefusesWhatIsNotCovered) {
  EXPECT_TRUE(Between(ImuBuffer(), 0, 10).samples.empty());
  EXPECT_TRUE(Between(EveryFiveMs(10), -1, 10).samples.empty());
  EXPECT_TRUE(Between(EveryFiveMs(10), 20, 10).samples.empty());
}

TEST(ImuBufferTest, CountsGaps) {
  ImuBuffer buffer;
  for (double ms : {0, 5, 30, 35, 40, 90, 95})
    buffer.Add(Sample(ms));
  EXPECT_EQ(Between(buffer, 0, 5).gaps, 0);
  EXPECT_EQ(Between(buffer, 0, 95).gaps, 2);
  EXPECT_EQ(Between(buffer, 0, 95).longest_gap, Duration{50'000'000});
  EXPECT_EQ(Between(buffer, 35, 64).gaps, 1) << "where a hole becomes known";
  EXPECT_EQ(Between(buffer, 64, 80).gaps, 0) << "inside the hole";
  EXPECT_EQ(Between(buffer, 80, 95).gaps, 0) << "at its end";
  EXPECT_EQ(Between(buffer, 80, 95).longest_gap, Duration{50'000'000});
  EXPECT_EQ(Between(buffer, 30, 40).gaps, 0) << "between two holes";
}

// Sensors of 10 to 1000 Hz; the camera is in step with none of them.
TEST(ImuBufferTest, ASlowSensorHasNoHoles) {
  for (double step_ms : {100.0, 50.0, 33.3, 25.0, 20.0, 10.0, 5.0, 1.0}) {
    ImuBuffer buffer;
    double newest_ms = 0;
    buffer.Add(Sample(0));
    for (double ms = 200; ms < 5000; ms += 50) {
      while (newest_ms <= ms) {
        newest_ms += step_ms;
        const double jitter_ms = 0.1 * step_ms * std::sin(newest_ms);
        buffer.Add(Sample(newest_ms + jitter_ms));
      }
      const ImuInterval interval = Between(buffer, ms - 50, ms);
      EXPECT_EQ(interval.gaps, 0) << step_ms << " ms";
      EXPECT_FALSE(interval.has_hole) << step_ms << " ms";
      EXPECT_GE(interval.samples.size(), 2u) << step_ms << " ms";
    }
    // Three of its samples are missing.
    newest_ms += std::max(4 * step_ms, 30.0);
    buffer.Add(Sample(newest_ms));
    const ImuInterval interval = Between(buffer, 4950, newest_ms);
    EXPECT_EQ(interval.gaps, 1) << step_ms << " ms";
    EXPECT_TRUE(interval.has_hole) << step_ms << " ms";
  }
}

TEST(ImuBufferTest, HoldsTheLastSampleOfASlowSensorUntilTheNextIsDue) {
  ImuBuffer buffer;
  for (int i = 0; i < 10; ++i)
    buffer.Add(Sample(50.0 * i));  // up to 450 ms
  EXPECT_EQ(Between(buffer, 400, 500).samples.size(), 3u);
  EXPECT_TRUE(Between(buffer, 400, 530).samples.empty());
}

TEST(ImuBufferTest, ASecondOfDamageDoesNotMakeHolesUsual) {
  ImuBuffer buffer = EveryFiveMs(300);  // up to 1495 ms
  for (int i = 1; i <= 20; ++i)
    buffer.Add(Sample(1495 + 50.0 * i));
  EXPECT_EQ(Between(buffer, 1495, 2495).gaps, 20);
}

TEST(ImuBufferTest, DoesNotLookAcrossAHole) {
  ImuBuffer one, other;
  for (double ms : {0, 5, 10, 15, 20})
    one.Add(Sample(ms)), other.Add(Sample(ms));
  one.Add(Sample(80));
  ImuSample altered = Sample(80);
  altered.gyro *= -3;
  other.Add(altered);
  for (const ImuBuffer* buffer : {&one, &other}) {
    const ImuInterval held = Between(*buffer, 12, 28);
    ASSERT_EQ(held.samples.size(), 4u);  // 12 15 20 28
    EXPECT_EQ(held.samples.back().gyro, Sample(20).gyro);
    EXPECT_TRUE(Between(*buffer, 28, 45).samples.empty());
  }
  // Once the hole is over its end is known.
  EXPECT_EQ(Between(one, 45, 80).samples.size(), 2u);
}

TEST(ImuBufferTest, RefusesWhatIsNotFiniteOrNotInOrder) {
  using Result = ImuBuffer::AddResult;
  ImuBuffer buffer;
  EXPECT_EQ(buffer.Add(Sample(10)), Result::kAdded);
  EXPECT_EQ(buffer.Add(Sample(10)), Result::kNotInOrder);
  EXPECT_EQ(buffer.Add(Sample(5)), Result::kNotInOrder);
  ImuSample bad = Sample(15);
  bad.gyro.y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(buffer.Add(bad), Result::kNotFinite);
  bad = Sample(15);
  bad.accel.z() = -std::numeric_limits<double>::infinity();
  EXPECT_EQ(buffer.Add(bad), Result::kNotFinite);
  bad.accel.z() = 1e200;
  EXPECT_EQ(buffer.Add(bad), Result::kNotFinite);
  EXPECT_EQ(buffer.Add(Sample(15)), Result::kAdded);
  EXPECT_EQ(buffer.size(), 2u);
}

TEST(ImuBufferTest, AStampFarInTheFutureIsLeftOut) {
  for (const double ahead_ms : {200.0, 3000.0, 1e7}) {
    ImuBuffer buffer = EveryFiveMs(100);
    buffer.Add(Sample(495 + ahead_ms));
    for (int i = 100; i < 200; ++i)
      EXPECT_EQ(buffer.Add(Sample(5.0 * i)), ImuBuffer::AddResult::kAdded) << ahead_ms;
    EXPECT_EQ(buffer.last_stamp(), Ms(995));
    EXPECT_EQ(buffer.num_stray(), 1);
    const ImuInterval interval = Between(buffer, 480, 520);
    EXPECT_FALSE(interval.has_hole) << ahead_ms;
    EXPECT_EQ(interval.samples.size(), 9u) << ahead_ms;
  }
}

TEST(ImuBufferTest, AStampFarInTheFutureThatComesFirstIsLeftOut) {
  ImuBuffer buffer;
  buffer.Add(Sample(1e7));
  for (int i = 0; i < 100; ++i)
    buffer.Add(Sample(5.0 * i));
  EXPECT_EQ(buffer.size(), 100u);
  EXPECT_EQ(buffer.num_stray(), 1);
}

TEST(ImuBufferTest, SeveralStrayStampsAreLeftOutInWhateverOrder) {
  ImuBuffer buffer = EveryFiveMs(100);
  for (const double ms : {9000.0, 9005.0, 7000.0, 8000.0})
    buffer.Add(Sample(ms));
  for (int i = 100; i < 200; ++i) {
    buffer.Add(Sample(5.0 * i));
    if (i % 10 == 0) buffer.Add(Sample(5000 + 5.0 * i));
  }
  EXPECT_EQ(buffer.size(), 200u);
  EXPECT_EQ(buffer.num_stray(), 14);
}

TEST(ImuBufferTest, AClockThatJumpsIsAGap) {
  ImuBuffer buffer = EveryFiveMs(100);  // up to 495 ms
  for (int i = 0; i < 100; ++i)
    buffer.Add(Sample(1e6 + 5.0 * i));
  EXPECT_EQ(buffer.num_stray(), 0);
  EXPECT_EQ(buffer.size(), 200u);
  EXPECT_EQ(Between(buffer, 490, 1e6 + 10).gaps, 1);
  // From there on the old time is over.
  EXPECT_EQ(buffer.Add(Sample(500)), ImuBuffer::AddResult::kNotInOrder);
}

TEST(ImuBufferTest, AfterAPauseAnImageOfTheSameTimeConfirmsTheFirstSamples) {
  ImuBuffer buffer = EveryFiveMs(100);  // up to 495 ms
  for (const double ms : {3000.0, 3005.0, 3010.0})
    buffer.Add(Sample(ms));
  EXPECT_EQ(buffer.last_stamp(), Ms(495));
  buffer.TimeIsAt(Ms(2999));
  EXPECT_EQ(buffer.last_stamp(), Ms(495));
  buffer.TimeIsAt(Ms(3007));
  EXPECT_EQ(buffer.last_stamp(), Ms(3010));
  EXPECT_EQ(Between(buffer, 3000, 3007).samples.size(), 3u);
}

TEST(ImuBufferTest, DropBeforeKeepsWhatInterpolationNeeds) {
  ImuBuffer buffer = EveryFiveMs(10);
  buffer.DropBefore(Ms(22));
  EXPECT_EQ(buffer.first_stamp(), Ms(20));
  EXPECT_EQ(Between(buffer, 22, 30).samples.size(), 3u);
  buffer.DropBefore(Ms(25));
  EXPECT_EQ(buffer.first_stamp(), Ms(25));
  buffer.DropBefore(Ms(1e6));
  EXPECT_EQ(buffer.size(), 1u);
  EXPECT_EQ(buffer.last_stamp(), Ms(45));
}

}  // namespace
}  // namespace facet
