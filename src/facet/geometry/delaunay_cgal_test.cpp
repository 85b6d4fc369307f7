// SPDX-License-Identifier: BSD-2-Clause
// Our triangulation against CGAL's (GPL, so in this test only). Points of a fine grid are almost
// never cocircular, and then the triangulation is unique.
#include <algorithm>
#include <array>
#include <set>

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/geometry/delaunay.h"

namespace facet {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Vertex = CGAL::Triangulation_vertex_base_with_info_2<int, Kernel>;
using Structure = CGAL::Triangulation_data_structure_2<Vertex>;
using Reference = CGAL::Delaunay_triangulation_2<Kernel, Structure>;
using Triangles = std::set<std::array<int, 3>>;

Triangles ReferenceTriangles(const std::vector<GridPoint>& points) {
  std::vector<std::pair<Kernel::Point_2, int>> input;
  for (std::size_t i = 0; i < points.size(); ++i)
    input.emplace_back(Kernel::Point_2(points[i].x, points[i].y), static_cast<int>(i));
  const Reference reference(input.begin(), input.end());
  Triangles triangles;
  for (auto f = reference.finite_faces_begin(); f != reference.finite_faces_end(); ++f) {
    std::array<int, 3> t = {f->vertex(0)->info(), f->vertex(1)->info(), f->vertex(2)->info()};
    std::sort(t.begin(), t.end());
    triangles.insert(t);
  }
  return triangles;
}

TEST(DelaunayCgal, SameTriangles) {
  Rng rng(11);
  Delaunay delaunay;
  for (int trial = 0; trial < 60; ++trial) {
    const int count = 3 + rng.Index(800);
    std::set<GridPoint> distinct;
    while (static_cast<int>(distinct.size()) < count)
      distinct.insert({rng.Index(2 * kMaxGridCoordinate) - kMaxGridCoordinate,
                       rng.Index(2 * kMaxGridCoordinate) - kMaxGridCoordinate});
    const std::vector<GridPoint> points(distinct.begin(), distinct.end());
    Triangles ours;
    for (std::array<int, 3> t : delaunay.Triangulate(points)) {
      std::sort(t.begin(), t.end());
      ours.insert(t);
    }
    ASSERT_EQ(ours, ReferenceTriangles(points)) << "trial " << trial;
  }
}

// Where points are cocircular the choice is free, but the number of triangles is not.
TEST(DelaunayCgal, AsManyTrianglesOnCoarseGrids) {
  Rng rng(12);
  Delaunay delaunay;
  for (int trial = 0; trial < 200; ++trial) {
    std::set<GridPoint> distinct;
    const int count = 3 + rng.Index(60);
    for (int i = 0; i < count; ++i)
      distinct.insert({rng.Index(9), rng.Index(9)});
    const std::vector<GridPoint> points(distinct.begin(), distinct.end());
    ASSERT_EQ(delaunay.Triangulate(points).size(), ReferenceTriangles(points).size());
  }
}

}  // namespace
}  // namespace facet
