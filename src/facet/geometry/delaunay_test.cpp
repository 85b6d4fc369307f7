// SPDX-License-Identifier: BSD-2-Clause
#include "facet/geometry/delaunay.h"

#include <algorithm>
#include <map>
#include <set>

#include <gtest/gtest.h>

#include "facet/base/check.h"
#include "facet/base/random.h"

namespace facet {
namespace {

using Points = std::vector<GridPoint>;
using Triangles = std::vector<std::array<int, 3>>;

/// Twice the area of the convex hull, by walking around it (monotone chain).
std::int64_t HullArea(Points points) {
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return 0;
  Points hull;
  for (int pass = 0; pass < 2; ++pass) {
    const std::size_t start = hull.size();
    for (const GridPoint& p : points) {
      while (hull.size() >= start + 2 && Orientation(hull[hull.size() - 2], hull.back(), p) <= 0) {
        hull.pop_back();
      }
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  std::int64_t area = 0;
  for (std::size_t i = 1; i + 1 < hull.size(); ++i)
    area += Orientation(hull[0], hull[i], hull[i + 1]);
  return area;
}

/// What makes a set of triangles the Delaunay triangulation of the points: nothing but these
/// properties, checked against every point.
void ExpectDelaunay(const Points& points, const Triangles& triangles) {
  std::int64_t area = 0;
  std::map<std::pair<int, int>, int> edges;
  std::set<GridPoint> used;
  for (const auto& [a, b, c] : triangles) {
    ASSERT_GT(Orientation(points[a], points[b], points[c]), 0);
    area += Orientation(points[a], points[b], points[c]);
    for (const auto& edge : {std::pair{a, b}, std::pair{b, c}, std::pair{c, a}})
      ASSERT_EQ(++edges[edge], 1) << "two triangles on one side of an edge";
    for (int v : {a, b, c})
      used.insert(points[v]);
    for (const GridPoint& p : points)
      ASSERT_FALSE(InCircle(points[a], points[b], points[c], p));
  }
  // Positive triangles without a common side of an edge, of the area of the hull: they cover it.
  EXPECT_EQ(area, HullArea(points));
  if (area > 0) {
    EXPECT_EQ(used.size(), std::set<GridPoint>(points.begin(), points.end()).size());
  }
}

Points RandomPoints(Rng& rng, int count, int range) {
  Points points(static_cast<std::size_t>(count));
  for (GridPoint& p : points)
    p = {rng.Index(range), rng.Index(range)};
  return points;
}

TEST(Delaunay, PropertiesHoldForRandomPoints) {
  Rng rng(1);
  Delaunay delaunay;
  for (int trial = 0; trial < 300; ++trial) {
    const Points points = RandomPoints(rng, rng.Index(120), 12000);
    ExpectDelaunay(points, delaunay.Triangulate(points));
  }
}

TEST(Delaunay, PropertiesHoldForManyEqualAndCocircularPoints) {
  Rng rng(2);
  Delaunay delaunay;
  for (int trial = 0; trial < 500; ++trial) {
    const Points points = RandomPoints(rng, rng.Index(60), 2 + rng.Index(7));
    ExpectDelaunay(points, delaunay.Triangulate(points));
  }
}

TEST(Delaunay, PropertiesHoldAtTheLargestCoordinates) {
  Points points;
  for (int x : {-kMaxGridCoordinate, 0, kMaxGridCoordinate})
    for (int y : {-kMaxGridCoordinate, 0, kMaxGridCoordinate - 1, kMaxGridCoordinate})
      points.push_back({x, y});
  ExpectDelaunay(points, Delaunay().Triangulate(points));
}

TEST(Delaunay, PropertiesHoldForPointsOnConvexCurves) {
  Points circle, parabola;
  for (int i = 0; i < 200; ++i) {
    circle.push_back({static_cast<int>(std::lround(100000 * std::cos(0.0314 * i))),
                      static_cast<int>(std::lround(100000 * std::sin(0.0314 * i)))});
    parabola.push_back({i, i * i});
  }
  ExpectDelaunay(circle, Delaunay().Triangulate(circle));
  ExpectDelaunay(parabola, Delaunay().Triangulate(parabola));
}

TEST(Delaunay, FewOrCollinearPointsHaveNoTriangles) {
  Delaunay delaunay;
  EXPECT_TRUE(delaunay.Triangulate({}).empty());
  for (int count = 1; count <= 40; ++count) {
    Points line, same(static_cast<std::size_t>(count), GridPoint{7, -3});
    for (int i = 0; i < count; ++i)
      line.push_back({3 * i, 5 - 2 * i});
    EXPECT_TRUE(delaunay.Triangulate(line).empty());
    EXPECT_TRUE(delaunay.Triangulate(same).empty());
  }
}

TEST(Delaunay, KeepsIndicesAndTheFirstOfEqualPoints) {
  const Points points = {{0, 0}, {10, 0}, {10, 0}, {0, 10}, {0, 0}};
  const Triangles triangles = Delaunay().Triangulate(points);
  ASSERT_EQ(triangles.size(), 1u);
  const std::set<int> corners(triangles[0].begin(), triangles[0].end());
  EXPECT_EQ(corners, (std::set<int>{0, 1, 3}));
}

TEST(Delaunay, OnePointMoreOrLessChangesOnlyItsSurroundings) {
  Rng rng(3);
  const Points points = RandomPoints(rng, 200, 12000);
  const Triangles all = Delaunay().Triangulate(points);
  const Points fewer(points.begin(), points.end() - 1);
  const Triangles part = Delaunay().Triangulate(fewer);
  const auto as_set = [](const Triangles& triangles) {
    std::set<std::set<int>> set;
    for (const auto& t : triangles)
      set.insert({t.begin(), t.end()});
    return set;
  };
  const auto a = as_set(all), b = as_set(part);
  int common = 0;
  for (const auto& t : a)
    common += static_cast<int>(b.count(t));
  EXPECT_GT(common, static_cast<int>(b.size()) - 20);
}

TEST(Delaunay, CoordinatesOutOfRangeAreAProgrammersError) {
  const Points points = {{kMaxGridCoordinate + 1, 0}};
  EXPECT_THROW(Delaunay().Triangulate(points), CheckError);
}

}  // namespace
}  // namespace facet
