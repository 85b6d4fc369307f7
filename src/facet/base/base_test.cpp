// SPDX-License-Identifier: BSD-2-Clause
#include <unordered_set>

#include <gtest/gtest.h>

#include "facet/base/check.h"
#include "facet/base/random.h"
#include "facet/base/stage_timer.h"
#include "facet/base/types.h"

namespace facet {
namespace {

TEST(TypesTest, StampsKeepEveryNanosecond) {
  const Timestamp t{1403636584763555584};
  const Timestamp later = t + FromSeconds(0.05);
  EXPECT_EQ((later - t).ns, 50000000);
  EXPECT_DOUBLE_EQ(ToSeconds(later - t), 0.05);
  EXPECT_LT(t, later);
}

// Signed numbers that overflow are undefined behaviour, and files may hold any stamp.
TEST(TypesTest, TimeStopsAtTheEndsOf64Bits) {
  constexpr std::int64_t kMin = std::numeric_limits<std::int64_t>::min();
  constexpr std::int64_t kMax = std::numeric_limits<std::int64_t>::max();
  EXPECT_EQ((Timestamp{kMax} - Timestamp{kMin}).ns, kMax);
  EXPECT_EQ((Timestamp{kMin} - Timestamp{kMax}).ns, kMin);
  EXPECT_EQ((Timestamp{kMax} + Duration{1}).ns, kMax);
  EXPECT_EQ((Timestamp{kMin} + Duration{-1}).ns, kMin);
  EXPECT_EQ((Timestamp{kMin} - Duration{1}).ns, kMin);
  EXPECT_EQ((Timestamp{-1} - Duration{kMin}).ns, kMax);
  EXPECT_EQ((Duration{kMax} + Duration{kMax}).ns, kMax);
  EXPECT_EQ(FromSeconds(1e300), FromSeconds(9.2e9));
  EXPECT_EQ(FromSeconds(-1e300), FromSeconds(-9.2e9));
  EXPECT_EQ(FromSeconds(std::nan("")).ns, 0);
}

TEST(TypesTest, IdsHashAndCompare) {
  std::unordered_set<LandmarkId> ids = {LandmarkId{3}, LandmarkId{3}, LandmarkId{4}};
  EXPECT_EQ(ids.size(), 2u);
  EXPECT_FALSE(LandmarkId{}.IsValid());
  EXPECT_TRUE(LandmarkId{0}.IsValid());
}

TEST(CheckTest, ThrowsWithFileAndValues) {
  try {
    FACET_CHECK(1 > 2) << "values " << 1 << ' ' << 2;
    FAIL() << "no exception";
  } catch (const CheckError& e) {
    EXPECT_NE(std::string(e.what()).find("base_test.cpp"), std::string::npos);
    EXPECT_NE(std::string(e.what()).find("values 1 2"), std::string::npos);
  }
}

TEST(RandomTest, NormalHasUnitMoments) {
  Rng rng(7);
  double sum = 0, sum2 = 0;
  const int n = 200000;
  for (int i = 0; i < n; ++i) {
    const double x = rng.Normal();
    sum += x;
    sum2 += x * x;
  }
  EXPECT_NEAR(sum / n, 0.0, 0.01);
  EXPECT_NEAR(sum2 / n, 1.0, 0.02);
}

TEST(RandomTest, SameSeedSameNumbers) {
  Rng a(42), b(42), c(43);
  EXPECT_EQ(a.Next(), b.Next());
  EXPECT_NE(a.Next(), c.Next());
}

TEST(StageTimerTest, AddsCpuTimeToItsStage) {
  StageTimes times;
  {
    ScopedStage stage(times, Stage::kOptimize);
    const double start = ThreadCpuMs();
    while (ThreadCpuMs() - start < 2.0) {
    }
  }
  EXPECT_GE(times[Stage::kOptimize], 2.0);
  EXPECT_DOUBLE_EQ(times.Total(), times[Stage::kOptimize]);
}

}  // namespace
}  // namespace facet
