// SPDX-License-Identifier: BSD-2-Clause
#include "warning_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace facet {
namespace {

using ::testing::ElementsAre;

const Timestamp kBegin{1'400'000'000'000'000'000};

TEST(WarningLogTest, TheSameKindAgainIsCountedWithTheLastTime) {
  WarningLog log;
  log.Add(kBegin + FromSeconds(2), "the IMU and the images contradicted each other by 5 times");
  log.Add(kBegin + FromSeconds(3), "for 3 s only 2 % of the corners were found");
  log.Add(kBegin + FromSeconds(9), "the IMU and the images contradicted each other by more");
  log.Add(kBegin + FromSeconds(61.3), "the IMU and the images contradicted each other by 7");
  EXPECT_THAT(log.Texts(kBegin),
              ElementsAre("the IMU and the images contradicted each other by 5 times (3 times, the "
                          "last at 61.3 s)",
                          "for 3 s only 2 % of the corners were found"));
}

TEST(WarningLogTest, OtherWordsAreAnotherKind) {
  WarningLog log;
  log.Add(kBegin, "for 3 s only 2 % of the corners were found");
  log.Add(kBegin, "for 3 s the IMU contradicted the images by 30 times");
  EXPECT_EQ(log.Texts(kBegin).size(), 2u);
}

// What is found wrong later must not be swallowed by what was found first.
TEST(WarningLogTest, ALongerListIsAnotherKind) {
  WarningLog log;
  const std::string begin = "the calibration is off by more than a careful one is: ",
                    end = "; this was estimated";
  log.Add(kBegin, begin + "focal length +1.0 %" + end);
  log.Add(kBegin, begin + "focal length +0.97 %, time offset -10 ms" + end);
  log.Add(kBegin, begin + "focal length -0.98 %, time offset +9.9 ms" + end);
  const std::vector<std::string> texts = log.Texts(kBegin);
  ASSERT_EQ(texts.size(), 2u);
  EXPECT_THAT(texts[1], ::testing::HasSubstr("time offset -10 ms; this was estimated (2 times"));
}

TEST(OccurrencesTest, NothingHappensAtNoTime) {
  Occurrences gaps;
  gaps.Add(kBegin + FromSeconds(4), 2);
  gaps.Add(kBegin + FromSeconds(5), 0);
  EXPECT_EQ(gaps.num, 2);
  EXPECT_EQ(gaps.WhenLast(kBegin), ", the last at 4.0 s");
}

}  // namespace
}  // namespace facet
