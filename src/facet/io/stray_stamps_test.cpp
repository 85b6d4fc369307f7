// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/stray_stamps.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace facet {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

struct Item {
  Timestamp t;
};

struct Outcome {
  std::vector<std::int64_t> taken, left_out;  // ms
};

// A stream in which three items confirm a step.
Outcome Filter(const std::vector<std::int64_t>& stamps_ms) {
  Outcome outcome;
  StrayStamps<Item> filter(3);
  const auto add_to = [](std::vector<std::int64_t>& list) {
    return [&list](const Item& item) { list.push_back(item.t.ns / 1000000); };
  };
  const auto take = add_to(outcome.taken), leave_out = add_to(outcome.left_out);
  for (const std::int64_t ms : stamps_ms)
    filter.Add({Timestamp{ms * 1000000}}, take, leave_out);
  filter.End(take, leave_out);
  return outcome;
}

// Of the first two nobody knows which is right.
TEST(StrayStampsTest, AStampFarAheadIsLeftOutWhereverItIs) {
  const std::vector<std::int64_t> good = {100, 150, 200, 250, 300};
  for (std::size_t i = 0; i < good.size(); ++i) {
    for (const std::int64_t ahead : {2000, 1000000000}) {
      std::vector<std::int64_t> stamps = good, expected = good;
      stamps[i] += ahead;
      expected.erase(expected.begin() + static_cast<std::ptrdiff_t>(i));
      if (i == 1) expected.erase(expected.begin());
      const Outcome outcome = Filter(stamps);
      EXPECT_EQ(outcome.taken, expected) << i;
      EXPECT_THAT(outcome.left_out, Contains(stamps[i])) << i;
    }
  }
}

TEST(StrayStampsTest, TwoInARowAreLeftOut) {
  EXPECT_THAT(Filter({100, 150, 200, 9000, 9050, 250}).left_out, ElementsAre(9000, 9050));
  EXPECT_THAT(Filter({100, 150, 200, 9000, 70000, 250}).left_out, ElementsAre(9000, 70000));
}

TEST(StrayStampsTest, APauseIsNone) {
  const std::vector<std::int64_t> stamps = {100, 150, 200, 9000, 9050, 9100, 9150};
  EXPECT_EQ(Filter(stamps).taken, stamps);
}

TEST(StrayStampsTest, WhatComesLateOrTwiceIsPassedOn) {
  const std::vector<std::int64_t> stamps = {100, 100, 50, 150, 200, 9000, 170, 9000, 8990, 9010};
  const Outcome outcome = Filter(stamps);
  EXPECT_THAT(outcome.taken, ElementsAre(100, 100, 50, 150, 200, 170, 9000, 9000, 8990, 9010));
  EXPECT_THAT(outcome.left_out, IsEmpty());
}

TEST(StrayStampsTest, ShortStreamsAreWhole) {
  EXPECT_THAT(Filter({100, 150}).taken, ElementsAre(100, 150));
  EXPECT_THAT(Filter({}).taken, IsEmpty());
}

TEST(StrayStampsTest, StampsMayBeAnything) {
  constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max() / 1000000;
  EXPECT_THAT(Filter({-kMost, kMost, 100, 150, 200}).taken, ElementsAre(100, 150, 200));
}

}  // namespace
}  // namespace facet
