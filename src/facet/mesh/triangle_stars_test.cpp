// SPDX-License-Identifier: BSD-2-Clause
#include "facet/mesh/triangle_stars.h"

#include <algorithm>
#include <array>

#include <gtest/gtest.h>

#include "facet/base/random.h"

namespace facet {
namespace {

using Triangle = std::array<int, 3>;

void Build(TriangleStars& stars, int num_points, const std::vector<Triangle>& triangles) {
  stars.Build(static_cast<std::size_t>(num_points),
              triangles.size(),
              [&](std::size_t i) -> const Triangle& { return triangles[i]; });
}

TEST(TriangleStars, ListsTheTrianglesOfEachPoint) {
  Rng rng(1);
  TriangleStars stars;
  for (int trial = 0; trial < 50; ++trial) {
    const int num_points = 3 + trial;
    std::vector<Triangle> triangles;
    for (int i = 0; i < 3 * trial; ++i) {
      Triangle t{};
      for (int& corner : t)
        corner = static_cast<int>(rng.Uniform(0, num_points - 0.001));
      if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) triangles.push_back(t);
    }
    Build(stars, num_points, triangles);
    for (int p = 0; p < num_points; ++p) {
      std::vector<int> expected;
      for (std::size_t i = 0; i < triangles.size(); ++i) {
        if (std::find(triangles[i].begin(), triangles[i].end(), p) != triangles[i].end())
          expected.push_back(static_cast<int>(i));
      }
      const auto found = stars.Around(p);
      EXPECT_TRUE(std::equal(found.begin(), found.end(), expected.begin(), expected.end())) << p;
    }
  }
}

TEST(TriangleStars, PointsWithoutTrianglesHaveNone) {
  TriangleStars stars;
  Build(stars, 5, {{{0, 1, 3}}});
  EXPECT_TRUE(stars.Around(2).empty());
  EXPECT_TRUE(stars.Around(4).empty());
  EXPECT_EQ(stars.Around(3).size(), 1U);
  Build(stars, 2, {});
  EXPECT_TRUE(stars.Around(1).empty());
}

}  // namespace
}  // namespace facet
