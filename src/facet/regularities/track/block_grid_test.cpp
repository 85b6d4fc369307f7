// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/track/block_grid.h"

#include <limits>
#include <map>
#include <utility>

#include <gtest/gtest.h>

#include "facet/base/random.h"

namespace facet {
namespace {

TEST(BlockGridTest, HoldsWhatAMapHoldsWhereverItGrows) {
  Rng rng(3);
  BlockGrid grid;
  std::map<std::pair<int, int>, std::uint32_t> expected;
  for (int k = 0; k < 2000; ++k) {
    const int reach = 1 + k / 20;
    const int x = static_cast<int>(rng.Uniform(-reach, 2 * reach));
    const int y = static_cast<int>(rng.Uniform(-3 * reach, reach));
    const auto value = static_cast<std::uint32_t>(k % 7);  // 0 takes a block back
    *grid.At(y, x) = value;
    expected[{x, y}] = value;
  }
  std::erase_if(expected, [](const auto& block) { return block.second == 0; });
  std::map<std::pair<int, int>, std::uint32_t> held;
  grid.ForEach([&](int x, int y, std::uint32_t value) { held[{y, x}] = value; });
  EXPECT_EQ(held, expected);
  for (const auto& [place, value] : expected)
    EXPECT_EQ(grid.Get(place.second, place.first), value);
}

TEST(BlockGridTest, WhatWasNeverSetIsZero) {
  BlockGrid grid;
  EXPECT_EQ(grid.Get(0, 0), 0u);
  *grid.At(-4, 7) = 1;
  constexpr int kMin = std::numeric_limits<int>::min(), kMax = std::numeric_limits<int>::max();
  EXPECT_EQ(grid.Get(-3, 7), 0u);
  EXPECT_EQ(grid.Get(-4, 6), 0u);
  for (const int x : {kMin, kMax}) {
    EXPECT_EQ(grid.Get(x, 7), 0u);
    EXPECT_EQ(grid.Get(-4, x), 0u);
  }
}

TEST(BlockGridTest, RefusesWhatWouldBeTooLarge) {
  constexpr int kMin = std::numeric_limits<int>::min(), kMax = std::numeric_limits<int>::max();
  constexpr int kSide = 2048;  // kMaxBlocks is its square
  for (const int corner : {-1, 1}) {
    BlockGrid grid;
    *grid.At(0, 0) = 3;
    for (const int x : {kMin, kMax, 2 * kSide}) {
      EXPECT_EQ(grid.At(x, x == 2 * kSide ? kSide : 0), nullptr);
      EXPECT_EQ(grid.At(x, x), nullptr);
    }
    // Up to the limit, without room for more.
    std::uint32_t* const last = grid.At(corner * (kSide - 1), corner * (kSide - 1));
    ASSERT_NE(last, nullptr);
    *last = 5;
    EXPECT_EQ(grid.At(corner * kSide, corner * kSide), nullptr);
    EXPECT_EQ(grid.Get(0, 0), 3u);
    EXPECT_EQ(grid.Get(corner * (kSide - 1), corner * (kSide - 1)), 5u);
  }
}

}  // namespace
}  // namespace facet
