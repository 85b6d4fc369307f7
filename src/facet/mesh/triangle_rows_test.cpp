// SPDX-License-Identifier: BSD-2-Clause
#include "facet/mesh/triangle_rows.h"

#include <limits>

#include <gtest/gtest.h>

#include "facet/base/random.h"

namespace facet {
namespace {

constexpr WholeNumbers kLimits = {-9, 11};

// Every place is looked at.
TEST(TriangleRows, FindsThePlacesInside) {
  Rng rng(1);
  int inside = 0;
  for (int trial = 0; trial < 500; ++trial) {
    std::array<Vector2d, 3> normals;
    std::array<double, 3> offsets{};
    const Vector2d centre(rng.Uniform(-12, 12), rng.Uniform(-12, 12));
    for (std::size_t s = 0; s < 3; ++s) {
      const double angle = 2.1 * static_cast<double>(s) + rng.Uniform(-0.5, 0.5) + 0.01 * trial;
      normals[s] = Vector2d(std::cos(angle), std::sin(angle));
      if (trial % 5 == 0 && s == 0) normals[s] = Vector2d(0, trial % 2 == 0 ? 1 : -1);
      offsets[s] = normals[s].dot(centre) - rng.Uniform(0, 8);
    }
    const TriangleRows rows(normals, offsets);
    for (int y = -15; y <= 15; ++y) {
      const WholeNumbers found = rows.Columns(y, kLimits);
      for (int x = -15; x <= 15; ++x) {
        bool expected = x >= kLimits.first && x <= kLimits.last;
        for (std::size_t s = 0; s < 3; ++s)
          expected = expected && normals[s].dot(Vector2d(x, y)) >= offsets[s];
        ASSERT_EQ(x >= found.first && x <= found.last, expected) << x << " " << y;
        inside += expected ? 1 : 0;
      }
    }
  }
  EXPECT_GT(inside, 10000);
}

TEST(TriangleRows, WholeNumbersBetweenAnyBounds) {
  const auto count = [](double low, double high) {
    const auto [first, last] = WholeNumbersBetween(low, high, kLimits);
    return last - first + 1;
  };
  EXPECT_EQ(count(-0.5, 0.5), 1);
  EXPECT_EQ(count(-2, 3), 6);
  EXPECT_EQ(count(-2.1, -1.9), 1);
  EXPECT_EQ(count(0.1, 0.9), 0);
  EXPECT_EQ(count(1, 0), 0);
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(count(-infinity, infinity), 21);
  EXPECT_EQ(count(-1e300, -9), 1);
  EXPECT_EQ(count(12, infinity), 0);
  EXPECT_EQ(count(std::numeric_limits<double>::quiet_NaN(), 1), 0);
}

}  // namespace
}  // namespace facet
