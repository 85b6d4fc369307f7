// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/disparity_watch.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace facet {
namespace {

using Verdict = DisparityWatch::Verdict;

constexpr double kFocalLength_px = 460;

DisparityShift Shift(double px, int num = 100, double spread_px = 0.1) {
  return {num, std::abs(px) < 2 ? num : 0, px / kFocalLength_px, spread_px / kFocalLength_px};
}

/// Keyframes every 0.3 s.
class Keyframes {
 public:
  Verdict Add(const DisparityShift& shift, bool in_doubt = false) {
    t_ = t_ + FromSeconds(0.3);
    return watch_.Add(t_, shift, in_doubt);
  }
  double turn() const { return watch_.turn(); }
  void Forget() { watch_.Forget(t_); }

 private:
  DisparityWatch watch_{kFocalLength_px};
  Timestamp t_;
};

TEST(DisparityWatchTest, WhatIsUsualAgrees) {
  Keyframes watch;
  for (int i = 0; i < 50; ++i)
    EXPECT_EQ(watch.Add(Shift(0.4 + 0.2 * (i % 2))), Verdict::kAgrees) << i;
  // A calibration that is half a pixel wrong has got used to that.
  EXPECT_EQ(watch.Add(Shift(1.0)), Verdict::kAgrees);
  EXPECT_EQ(watch.Add(Shift(-0.4)), Verdict::kContradicts);
}

TEST(DisparityWatchTest, WhatWasUsualWithAnotherCalibrationIsForgotten) {
  Keyframes watch;
  for (int i = 0; i < 50; ++i)
    EXPECT_EQ(watch.Add(Shift(0.6)), Verdict::kAgrees);
  EXPECT_EQ(watch.Add(Shift(-0.3)), Verdict::kContradicts);
  watch.Forget();
  for (int i = 0; i < 9; ++i)
    EXPECT_EQ(watch.Add(Shift(2 - 0.2 * i)), Verdict::kAgrees) << "depths follow";
  for (int i = 0; i < 5; ++i)
    EXPECT_EQ(watch.Add(Shift(-0.3)), Verdict::kAgrees);
  EXPECT_EQ(watch.Add(Shift(0.9)), Verdict::kContradicts);
}

TEST(DisparityWatchTest, OneImageOfAnotherMomentIsNotUsed) {
  Keyframes watch;
  EXPECT_EQ(watch.Add(Shift(0)), Verdict::kAgrees);
  EXPECT_EQ(watch.Add(Shift(3)), Verdict::kContradicts);
  EXPECT_EQ(watch.Add(Shift(0)), Verdict::kAgrees);
  EXPECT_EQ(watch.Add(Shift(3)), Verdict::kContradicts);
  EXPECT_EQ(watch.Add(Shift(3)), Verdict::kContradicts);
  EXPECT_EQ(watch.Add(Shift(0)), Verdict::kAgrees);
}

TEST(DisparityWatchTest, ASecondThatAgreesIsATurn) {
  Keyframes watch;
  for (int i = 0; i < 50; ++i)
    EXPECT_EQ(watch.Add(Shift(0.3)), Verdict::kAgrees);
  EXPECT_EQ(watch.Add(Shift(-2.6)), Verdict::kContradicts);
  EXPECT_EQ(watch.Add(Shift(-2.8)), Verdict::kContradicts);
  EXPECT_EQ(watch.Add(Shift(-2.6)), Verdict::kContradicts);
  EXPECT_EQ(watch.Add(Shift(-2.8)), Verdict::kContradicts);
  EXPECT_EQ(watch.Add(Shift(-2.7)), Verdict::kTurned);
  EXPECT_NEAR(watch.turn(), -3.0 / kFocalLength_px, 0.02 / kFocalLength_px);
  EXPECT_EQ(watch.Add(Shift(0.3)), Verdict::kAgrees) << "corrected";
}

// Then the depths may be what is wrong, and only right images mend them.
TEST(DisparityWatchTest, WhatDoesNotAgreeIsNotKeptOutForLong) {
  Keyframes watch;
  int num_kept_out = 0;
  for (int i = 0; i < 100; ++i)
    num_kept_out += watch.Add(Shift(2 + i % 3)) != Verdict::kAgrees ? 1 : 0;
  EXPECT_GT(num_kept_out, 2);
  EXPECT_LT(num_kept_out, 20);
}

TEST(DisparityWatchTest, FewOrScatteredDisparitiesProveNothing) {
  Keyframes watch;
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(watch.Add(Shift(5, 10)), Verdict::kAgrees);
    EXPECT_EQ(watch.Add(Shift(5, 100, 3)), Verdict::kAgrees);
  }
}

// After a knock of a degree only things that are near have a match, and many matches are of other
// points.
TEST(DisparityWatchTest, InDoubtFewAreEnoughAndScatteredOnesAreNotUsed) {
  constexpr bool kInDoubt = true;
  Keyframes watch;
  EXPECT_EQ(watch.Add(Shift(3, 20, 4), kInDoubt), Verdict::kScatters);
  EXPECT_EQ(watch.Add(Shift(0.2, 20, 4), kInDoubt), Verdict::kAgrees) << "half of a covered lens";
  EXPECT_EQ(watch.Add(Shift(3, 5, 4), kInDoubt), Verdict::kScatters);
  EXPECT_EQ(watch.Add(Shift(3, 4, 4), kInDoubt), Verdict::kAgrees) << "and many new tracks";
  for (int i = 0; i < 4; ++i)
    EXPECT_EQ(watch.Add(Shift(9.5, 12), kInDoubt), Verdict::kContradicts) << i;
  EXPECT_EQ(watch.Add(Shift(9.5, 12), kInDoubt), Verdict::kTurned);
  for (int i = 0; i < 100; ++i)
    EXPECT_NE(watch.Add(Shift(2 + 3 * (i % 3)), kInDoubt), Verdict::kAgrees) << "nor later";
}

// As right images of another moment are, now and then.
TEST(DisparityWatchTest, ContradictionsThatAreFarApartAreNoTurn) {
  DisparityWatch watch(kFocalLength_px);
  const DisparityShift few = Shift(5, 2);
  for (const double t : {0.0, 0.1, 60.0, 60.1, 60.2}) {
    EXPECT_EQ(watch.Add(Timestamp{} + FromSeconds(t), Shift(5), false), Verdict::kContradicts) << t;
    EXPECT_EQ(watch.Add(Timestamp{} + FromSeconds(t + 0.05), few, false), Verdict::kAgrees);
  }
}

}  // namespace
}  // namespace facet
