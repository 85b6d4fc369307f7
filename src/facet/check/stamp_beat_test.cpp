// SPDX-License-Identifier: BSD-2-Clause
#include "facet/check/stamp_beat.h"

#include <gtest/gtest.h>

#include "facet/base/random.h"

namespace facet {
namespace {

constexpr double kInterval_s = 0.05, kGap_s = 0.45;

Timestamp At(double t_s) {
  return Timestamp{} + FromSeconds(1e9 + t_s);
}

TEST(StampBeatTest, ARegularBeatHasNothing) {
  StampBeat beat(kGap_s);
  for (int i = 0; i < 3000; ++i)
    beat.Add(At(i * kInterval_s));
  beat.End();
  EXPECT_EQ(beat.num(), 3000);
  EXPECT_NEAR(beat.median_s(), kInterval_s, 1e-6);
  EXPECT_LT(beat.jitter_s(), 1e-6);
  EXPECT_LT(beat.missing_share(), 1e-5);
  EXPECT_EQ(beat.num_gaps(), 0);
}

TEST(StampBeatTest, JitterIsThatOfAStamp) {
  Rng rng(1);
  StampBeat beat(kGap_s);
  for (int i = 0; i < 3000; ++i)
    beat.Add(At(i * kInterval_s + 0.004 * rng.Normal()));
  beat.End();
  EXPECT_NEAR(beat.jitter_s(), 0.004, 0.0003);
  EXPECT_LT(beat.missing_share(), 0.01);
}

TEST(StampBeatTest, WhatIsMissingIsCountedOutsideOfGaps) {
  Rng rng(2);
  StampBeat beat(kGap_s);
  for (int i = 0; i < 3000; ++i) {
    const double t_s = i * kInterval_s;
    if (rng.Uniform() < 0.1 || (t_s > 20 && t_s < 22)) continue;
    beat.Add(At(t_s));
  }
  beat.End();
  EXPECT_NEAR(beat.missing_share(), 0.1, 0.02);
  ASSERT_EQ(beat.num_gaps(), 1);
  EXPECT_NEAR(ToSeconds(beat.longest_gap()->to - beat.longest_gap()->from), 2, 0.15);
  EXPECT_LT(beat.jitter_s(), 1e-6);
}

TEST(StampBeatTest, AGapOfTheFirstStampsIsFound) {
  StampBeat beat(0.09);
  beat.Add(At(0));
  for (int i = 0; i < 20; ++i)
    beat.Add(At(0.2 + 0.005 * i));
  beat.End();
  EXPECT_EQ(beat.num_gaps(), 1);
  EXPECT_NEAR(beat.median_s(), 0.005, 1e-6);
}

}  // namespace
}  // namespace facet
