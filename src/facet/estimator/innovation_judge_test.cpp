// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/innovation_judge.h"

#include <gtest/gtest.h>

namespace facet {
namespace {

constexpr Timestamp kBegin{1'400'000'000'000'000'000};

Timestamp At(double seconds) {
  return kBegin + FromSeconds(seconds);
}

InnovationTest Counts(int num_tested,
                      int num_contradicting,
                      int num_witnesses,
                      int num_contradicting_witnesses) {
  InnovationTest test;
  test.num_tested = num_tested;
  test.num_contradicting = num_contradicting;
  test.num_witnesses = num_witnesses;
  test.num_contradicting_witnesses = num_contradicting_witnesses;
  return test;
}

TEST(InnovationJudgeTest, WhatMovesIsLeftOutHoweverMuchItIs) {
  InnovationJudge judge;
  EXPECT_TRUE(judge.LeavesOut(Counts(100, 10, 60, 0), At(0)));
  EXPECT_TRUE(judge.LeavesOut(Counts(200, 185, 10, 0), At(0.1)));
}

TEST(InnovationJudgeTest, AnImuThatAllWitnessesContradictIsNotBelieved) {
  InnovationJudge judge;
  EXPECT_TRUE(judge.LeavesOut(Counts(100, 0, 60, 0), At(0)));
  EXPECT_FALSE(judge.LeavesOut(Counts(100, 90, 60, 55), At(0.1)));
}

TEST(InnovationJudgeTest, WithoutWitnessesAConfirmedImuIsBelievedForTwoSeconds) {
  InnovationJudge judge;
  EXPECT_TRUE(judge.LeavesOut(Counts(100, 0, 60, 0), At(0)));
  EXPECT_TRUE(judge.LeavesOut(Counts(100, 100, 0, 0), At(1.9)));
  EXPECT_FALSE(judge.LeavesOut(Counts(100, 100, 0, 0), At(2.1)));
}

// After a start there are none yet.
TEST(InnovationJudgeTest, BeforeThereWereWitnessesAQuarterMustAgree) {
  InnovationJudge judge;
  EXPECT_TRUE(judge.LeavesOut(Counts(100, 70, 0, 0), At(0)));
  EXPECT_FALSE(judge.LeavesOut(Counts(100, 80, 0, 0), At(0.1)));
  EXPECT_FALSE(judge.LeavesOut(Counts(7, 0, 0, 0), At(0.2)));
}

TEST(InnovationJudgeTest, WitnessesThatHalfContradictConfirmNothing) {
  InnovationJudge judge;
  EXPECT_TRUE(judge.LeavesOut(Counts(100, 50, 60, 35), At(0)));
  EXPECT_FALSE(judge.LeavesOut(Counts(100, 100, 0, 0), At(0.1)));
}

TEST(InnovationJudgeTest, AgreementsAreCountedForLandmarksOfTheWindow) {
  SlidingWindow window;
  window.frames.resize(1);
  window.AddLandmark(LandmarkId{4}, 0);
  window.AddLandmark(LandmarkId{5}, 0);
  std::vector<PreparedObservation> observations(3);
  for (std::size_t k = 0; k < 3; ++k)
    observations[k].landmark = LandmarkId{4 + static_cast<int>(k)};
  InnovationTest test;
  test.agrees = {1, 0, 1};
  test.contradicts = {0, 0, 0};
  Remember(test, observations, window);
  Remember(test, observations, window);
  EXPECT_EQ(window.Find(LandmarkId{4})->num_confirmed, 2);
  EXPECT_EQ(window.Find(LandmarkId{5})->num_confirmed, 0);
  EXPECT_EQ(window.landmarks().size(), 2u);
}

TEST(InnovationJudgeTest, WhatHasMovedIsLeftOutUntilItAgreesForThreeKeyframes) {
  SlidingWindow window;
  window.frames.resize(1);
  window.AddLandmark(LandmarkId{4}, 0);
  window.AddLandmark(LandmarkId{5}, 0);
  std::vector<PreparedObservation> all(2);
  all[0].landmark = LandmarkId{4};
  all[1].landmark = LandmarkId{5};
  InnovationTest test;
  test.agrees = {1, 0};
  test.contradicts = {0, 1};
  test.is_witness = {0, 0};
  std::vector<std::size_t> num_left;
  for (int keyframe = 0; keyframe < 5; ++keyframe) {
    Remember(test, all, window);
    std::vector<PreparedObservation> observations = all;
    LeaveOutMoving(test, window, observations);
    num_left.push_back(observations.size());
    test.agrees = {1, 1};
    test.contradicts = {0, 0};
  }
  EXPECT_EQ(num_left, (std::vector<std::size_t>{1, 1, 1, 2, 2}));
}

// Ten witnesses that agree, others of which some agree, and one that was not tested: how many are
// left.
std::size_t NumLeft(int num_others, int num_contradicting, int num_contradicting_witnesses = 0) {
  constexpr int kWitnesses = 10;
  SlidingWindow window;
  window.frames.resize(1);
  InnovationTest test = Counts(kWitnesses + num_others,
                               num_contradicting + num_contradicting_witnesses,
                               kWitnesses,
                               num_contradicting_witnesses);
  std::vector<PreparedObservation> observations;
  for (int i = 0; i <= kWitnesses + num_others; ++i) {
    const LandmarkId id{i};
    window.AddLandmark(id, 0);
    observations.emplace_back().landmark = id;
    const bool is_tested = i < kWitnesses + num_others, is_witness = i < kWitnesses;
    const int moving = is_witness ? num_contradicting_witnesses : num_contradicting;
    const bool contradicts = is_tested && (is_witness ? i : i - kWitnesses) < moving;
    test.is_witness.push_back(is_witness);
    test.contradicts.push_back(contradicts);
    test.agrees.push_back(is_tested && !contradicts);
  }
  LeaveOutMoving(test, window, observations);
  return observations.size();
}

TEST(InnovationJudgeTest, WhatAgreesInACrowdThatMovesIsLeftOut) {
  EXPECT_EQ(NumLeft(100, 75), 10U + 1) << "witnesses, and what was not tested";
  EXPECT_EQ(NumLeft(100, 60), 10U + 40 + 1) << "not enough move";
  EXPECT_EQ(NumLeft(9, 8), 10U + 1 + 1) << "the crowd is no larger than the witnesses";
  EXPECT_EQ(NumLeft(100, 75, 3), 7U + 25 + 1) << "too few witnesses agree";
}

}  // namespace
}  // namespace facet
