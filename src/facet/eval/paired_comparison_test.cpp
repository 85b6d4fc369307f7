// SPDX-License-Identifier: BSD-2-Clause
#include "facet/eval/paired_comparison.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "facet/base/check.h"
#include "facet/base/random.h"

namespace facet {
namespace {

std::vector<double> LogNormalRatios(int n, double median, double spread, std::uint64_t seed) {
  Rng rng(seed);
  std::vector<double> ratios;
  for (int i = 0; i < n; ++i)
    ratios.push_back(median * std::exp(spread * rng.Normal()));
  return ratios;
}

TEST(PairedComparisonTest, SameRatiosSameInterval) {
  const auto ratios = LogNormalRatios(11, 0.9, 0.1, 4);
  const PairedComparison a = CompareRatios(ratios), b = CompareRatios(ratios);
  EXPECT_EQ(a.low, b.low);
  EXPECT_EQ(a.high, b.high);
  EXPECT_LE(a.low, a.median_ratio);
  EXPECT_GE(a.high, a.median_ratio);
}

TEST(PairedComparisonTest, ConstantRatios) {
  const PairedComparison gain = CompareRatios(std::vector<double>(9, 0.8));
  EXPECT_DOUBLE_EQ(gain.low, 0.8);
  EXPECT_DOUBLE_EQ(gain.high, 0.8);
  EXPECT_EQ(gain.verdict, Verdict::kReal);
  EXPECT_EQ(gain.num_better, 9);
  EXPECT_EQ(CompareRatios(std::vector<double>(9, 1.0)).verdict, Verdict::kNotShown);
}

TEST(PairedComparisonTest, FewStartsAreNotJudged) {
  EXPECT_EQ(CompareRatios(std::vector<double>(8, 0.5)).verdict, Verdict::kTooFewStarts);
  EXPECT_THROW(CompareRatios({}), CheckError);
}

TEST(PairedComparisonTest, IsRarelyWrongWithoutAnyDifference) {
  // 400 studies each. In the long run 3.9 % are called real with 9 starts, 1.2 % with 11 and 4.1 %
  // with 20; the limit is three standard errors above 5 %.
  for (int num_starts : {9, 11, 20}) {
    int num_real = 0;
    for (int study = 0; study < 400; ++study) {
      const auto ratios = LogNormalRatios(num_starts, 1, 0.2, 1000 * num_starts + study);
      num_real += CompareRatios(ratios, 2000).verdict == Verdict::kReal ? 1 : 0;
    }
    EXPECT_LE(num_real, 400 * (0.05 + 3 * 0.011)) << num_starts << " starts";
  }
}

TEST(PairedComparisonTest, IntervalIsNeverNarrowerThanTheOrderStatistics) {
  // With 11 values: the second and the tenth.
  const auto ratios = LogNormalRatios(11, 1, 0.2, 5);
  std::vector<double> sorted = ratios;
  std::sort(sorted.begin(), sorted.end());
  const PairedComparison comparison = CompareRatios(ratios);
  EXPECT_LE(comparison.low, sorted[1]);
  EXPECT_GE(comparison.high, sorted[9]);
}

TEST(PairedComparisonTest, SeesAClearDifference) {
  EXPECT_EQ(CompareRatios(LogNormalRatios(11, 0.7, 0.1, 7)).verdict, Verdict::kReal);
}

PosePair Pair(std::int64_t second, double error_x) {
  const Vector3d p(std::cos(1.0 * static_cast<double>(second)), static_cast<double>(second), 0);
  return {Timestamp{second * 1'000'000'000},
          SE3(Quaterniond::Identity(), p + Vector3d(error_x, 0, 0)),
          SE3(Quaterniond::Identity(), p)};
}

TEST(PairedComparisonTest, JudgesOnFramesThatAllRunsHave) {
  std::vector<PosePair> good, bad;
  for (int i = 0; i < 20; ++i) {
    if (i >= 5) good.push_back(Pair(i, i % 2 == 0 ? 0.01 : -0.01));
    // Far off before the other one begins: that must not count.
    if (i < 15) bad.push_back(Pair(i, i < 5 ? 10.0 : (i % 2 == 0 ? 0.02 : -0.02)));
  }
  const std::vector<std::vector<PosePair>> runs = {good, bad};
  const auto errors = ErrorsOnCommonFrames(runs, AlignmentKind::kSE3);
  ASSERT_TRUE(errors);
  EXPECT_EQ(errors->num_frames, 10u);
  EXPECT_NEAR(errors->rmse_m[1] / errors->rmse_m[0], 2, 1e-3);
  const std::vector<std::vector<PosePair>> apart = {{Pair(1, 0), Pair(2, 0)}, {Pair(3, 0)}};
  EXPECT_FALSE(ErrorsOnCommonFrames(apart, AlignmentKind::kSE3));
}

}  // namespace
}  // namespace facet
