// SPDX-License-Identifier: BSD-2-Clause
#include "facet/plausibility/turn_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/base/random.h"

namespace facet {
namespace {

using ::testing::HasSubstr;

// Turns of a body that turns by up to 6 deg between keyframes, with what is left of the
// gyroscope's bias; every twentieth one is nonsense.
DoubleTurn MakeTurn(double ratio, const Vector3d& bias, Rng& rng) {
  constexpr double kNoise = 0.0003, kTurn = 0.05;
  DoubleTurn turn;
  turn.dt_s = rng.Uniform(0.15, 0.4);
  const Vector3d truth = kTurn * rng.Normal3();
  turn.by_gyro = truth + turn.dt_s * bias;
  turn.by_images = ratio * truth + kNoise * rng.Normal3();
  if (rng.Index(20) == 0) turn.by_images += 0.02 * rng.Normal3();
  return turn;
}

struct TurnJudgement {
  int first_doubt = 0, num_doubts = 0;  // after how many turns
  TurnCheck::Ratio ratio;
};

TurnJudgement Judge(std::uint64_t seed, double ratio, int num_turns) {
  Rng rng(seed);
  const Vector3d bias = 0.003 * rng.Normal3();
  TurnCheck check;
  TurnJudgement out;
  for (int k = 1; k <= num_turns; ++k) {
    if (!check.Add(MakeTurn(ratio, bias, rng))) continue;
    if (out.num_doubts++ == 0) out.first_doubt = k;
  }
  out.ratio = check.ratio().value_or(TurnCheck::Ratio{});
  return out;
}

TEST(TurnCheckTest, TheRatioIsFoundWithinItsSigma) {
  double sum = 0;
  constexpr int kRuns = 40;
  for (int seed = 0; seed < kRuns; ++seed) {
    const double ratio = seed % 2 == 0 ? 1.0 : 1.01;
    const TurnJudgement judgement = Judge(static_cast<std::uint64_t>(seed), ratio, 60);
    sum += std::pow((judgement.ratio.value() - ratio) / judgement.ratio.sigma, 2);
    EXPECT_LT(judgement.ratio.sigma, 0.002) << seed;
  }
  // The sigma allows for errors of neighbours, which these turns do not have.
  EXPECT_GT(sum / kRuns, 0.2);
  EXPECT_LT(sum / kRuns, 1.5);
}

TEST(TurnCheckTest, FocalLengthsThatAreOffByOnePerCentAreDoubtedOnce) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const TurnJudgement judgement = Judge(seed, seed % 2 == 0 ? 0.99 : 1.01, 300);
    EXPECT_EQ(judgement.num_doubts, 1) << seed;
    EXPECT_GE(judgement.first_doubt, 30) << seed;
    EXPECT_LE(judgement.first_doubt, 60) << seed;
  }
}

TEST(TurnCheckTest, WhatACarefulCalibrationLeavesIsNotDoubted) {
  for (std::uint64_t seed = 0; seed < 100; ++seed)
    EXPECT_EQ(Judge(seed, seed % 2 == 0 ? 1.002 : 0.998, 300).num_doubts, 0) << seed;
}

TEST(TurnCheckTest, NegatedAndExchangedAxesAreNoAgreement) {
  Matrix3d same = Matrix3d::Identity(), negated = same, exchanged = same;
  negated(1, 1) = -1;
  exchanged.col(0).swap(exchanged.col(2));
  for (const Matrix3d& axes : {same, negated, exchanged}) {
    Rng rng(1);
    TurnCheck check;
    for (int k = 0; k < 40; ++k) {
      DoubleTurn turn = MakeTurn(1, Vector3d::Zero(), rng);
      // Mostly about one direction between the axes.
      const Vector3d more = 0.05 * rng.Normal() * Vector3d(1, 1, 1);
      turn.by_images += more;
      turn.by_gyro = axes * (turn.by_gyro + more);
      check.Add(turn);
    }
    EXPECT_EQ(check.DoAxesAgree(), axes == same) << axes;
  }
}

// At rest there is noise on both sides and nothing else.
TEST(TurnCheckTest, WithoutTurningNothingIsDoubted) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Rng rng(seed);
    TurnCheck check;
    for (int k = 0; k < 300; ++k) {
      const DoubleTurn turn{0.0003 * rng.Normal3(), 0.0001 * rng.Normal3(), 0.2};
      EXPECT_FALSE(check.Add(turn)) << seed << ", " << k;
    }
    EXPECT_TRUE(check.IsDone());
    EXPECT_FALSE(check.DoAxesAgree());
  }
}

// The images show something that turns with the rig.
TEST(TurnCheckTest, ImagesAtRestOnATurningRigAreNoFocalLength) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Rng rng(seed);
    TurnCheck check;
    for (int k = 0; k < 300; ++k)
      EXPECT_FALSE(check.Add({0.0003 * rng.Normal3(), 0.05 * rng.Normal3(), 0.2})) << seed;
  }
}

TEST(TurnCheckTest, SaysInWhichDirection) {
  EXPECT_THAT(TurnsInWords(TurnCheck::Ratio{0.99, 0.99, 0.001}),
              HasSubstr("1.00 % (1-sigma 0.10) less than"));
  EXPECT_THAT(TurnsInWords(TurnCheck::Ratio{1.02, 1.02, 0.001}),
              HasSubstr("2.00 % (1-sigma 0.10) more than"));
}

}  // namespace
}  // namespace facet
