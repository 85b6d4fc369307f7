// SPDX-License-Identifier: BSD-2-Clause
#include "facet/plausibility/specific_force_check.h"

#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace facet {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

// 5 s of a force, frame by frame.
std::string Judge(double force, SpecificForceCheck& check) {
  Timestamp t{1'400'000'000'000'000'000};
  for (int frame = 0; frame < 100; ++frame) {
    std::vector<ImuSample> samples;
    for (int i = 0; i <= 10; ++i)
      samples.push_back({t + Duration{5'000'000 * i}, Vector3d::Zero(), Vector3d(0, force, 0)});
    t = samples.back().t;
    const std::string words = check.Add(samples);
    if (!words.empty()) return words;
  }
  return {};
}

TEST(SpecificForceCheckTest, GravityConvinces) {
  for (const double force : {8.0, 9.8, 12.0, 15.0}) {
    SpecificForceCheck check;
    EXPECT_THAT(Judge(force, check), IsEmpty()) << force;
    EXPECT_TRUE(check.IsConvinced()) << force;
  }
}

TEST(SpecificForceCheckTest, NamesTheUnit) {
  SpecificForceCheck g, mg;
  EXPECT_THAT(Judge(1, g), AllOf(HasSubstr("measured 1 on average"), HasSubstr("in g")));
  EXPECT_THAT(Judge(1000, mg), AllOf(HasSubstr("1e+03"), Not(HasSubstr("in g"))));
  EXPECT_FALSE(g.IsConvinced());
}

TEST(SpecificForceCheckTest, ASensorThatMeasuresNothingIsNoReason) {
  SpecificForceCheck check;
  EXPECT_THAT(Judge(0, check), IsEmpty());
  EXPECT_FALSE(check.IsConvinced());
}

}  // namespace
}  // namespace facet
