// SPDX-License-Identifier: BSD-2-Clause
#include "facet/loop/place_index.h"

#include <gtest/gtest.h>

#include "facet/base/random.h"

namespace facet {
namespace {

constexpr int kNumPlaces = 60, kNumPoints = 150;

BinaryDescriptor RandomDescriptor(Rng& rng) {
  BinaryDescriptor descriptor{};
  for (std::uint64_t& word : descriptor) {
    for (int bit = 0; bit < 64; ++bit)
      word = word << 1 | static_cast<std::uint64_t>(rng.Uniform() < 0.5 ? 1 : 0);
  }
  return descriptor;
}

BinaryDescriptor Disturbed(BinaryDescriptor descriptor, double share, Rng& rng) {
  for (std::uint64_t& word : descriptor) {
    for (int bit = 0; bit < 64; ++bit) {
      if (rng.Uniform() < share) word ^= std::uint64_t{1} << bit;
    }
  }
  return descriptor;
}

std::deque<PlaceRecord> Places(Rng& rng) {
  std::deque<PlaceRecord> places(kNumPlaces);
  for (int i = 0; i < kNumPlaces; ++i) {
    places[i].t = Timestamp{i * 10'000'000'000};
    places[i].points.resize(kNumPoints);
    for (RecordPoint& point : places[i].points) {
      for (BinaryDescriptor& descriptor : point.descriptors)
        descriptor = RandomDescriptor(rng);
    }
  }
  return places;
}

/// A third of the corners are those of the place, with one bit in eight another; the others are of
/// nothing in the map.
std::vector<UprightCorner> ViewOf(const PlaceRecord& place, Rng& rng) {
  std::vector<UprightCorner> corners(300);
  for (std::size_t i = 0; i < corners.size(); ++i)
    corners[i].descriptor =
        i < 100 ? Disturbed(place.points[i].descriptors[1], 0.125, rng) : RandomDescriptor(rng);
  return corners;
}

TEST(PlaceIndexTest, ThePlaceThatIsSeenComesFirst) {
  Rng rng(1);
  const std::deque<PlaceRecord> places = Places(rng);
  const PlaceIndex index(places);
  for (int i = 0; i < kNumPlaces; ++i) {
    const std::vector<int> best = index.Best(ViewOf(places[i], rng), 3);
    ASSERT_FALSE(best.empty());
    EXPECT_EQ(best[0], i);
    EXPECT_LE(best.size(), 3u);
  }
}

TEST(PlaceIndexTest, OfNeighboursInTimeOnlyOneIsNamed) {
  Rng rng(2);
  std::deque<PlaceRecord> places = Places(rng);
  places[8].points = places[7].points;
  places[8].t = places[7].t + Duration{1'000'000'000};
  places[30].points = places[7].points;  // the same again, later
  const std::vector<int> best = PlaceIndex(places).Best(ViewOf(places[7], rng), 2);
  ASSERT_EQ(best.size(), 2u);
  EXPECT_TRUE((best[0] == 7) != (best[1] == 7) || (best[0] == 8) != (best[1] == 8));
  EXPECT_TRUE(best[0] == 30 || best[1] == 30);
}

// White walls and skies: all corners alike.
TEST(PlaceIndexTest, WhatEveryPlaceHasSaysNothing) {
  Rng rng(3);
  std::deque<PlaceRecord> places = Places(rng);
  for (PlaceRecord& place : places) {
    for (std::size_t i = 0; i < 60; ++i)
      place.points[i].descriptors[1] = BinaryDescriptor{};
  }
  std::vector<UprightCorner> corners(100);
  EXPECT_TRUE(PlaceIndex(places).Best(corners, 5).empty());
}

TEST(PlaceIndexTest, CountsItsMemory) {
  Rng rng(5);
  const std::deque<PlaceRecord> places = Places(rng);
  std::size_t num_points = 0;
  for (const PlaceRecord& place : places)
    num_points += place.points.size();
  // Eight tables of four bytes, which grow by doubling.
  EXPECT_GE(PlaceIndex(places).memory_bytes(), 32 * num_points);
  EXPECT_LE(PlaceIndex(places).memory_bytes(), 65 * num_points + 64 * places.size());
}

TEST(PlaceIndexTest, NothingIsFoundInNothing) {
  EXPECT_TRUE(PlaceIndex({}).Best(std::vector<UprightCorner>(5), 5).empty());
  Rng rng(4);
  EXPECT_TRUE(PlaceIndex(Places(rng)).Best({}, 5).empty());
}

}  // namespace
}  // namespace facet
