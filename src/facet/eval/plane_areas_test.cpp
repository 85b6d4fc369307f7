// SPDX-License-Identifier: BSD-2-Clause
#include "facet/eval/plane_areas.h"

#include <limits>

#include <gtest/gtest.h>

#include "facet/testing/eval/test_shapes.h"

namespace facet {
namespace {

TruePlane Level(double height_m) {
  TruePlane plane;
  plane.d_G = height_m;
  return plane;
}

std::optional<PlaneAreaFigures> Evaluate(const TriangleMesh& mesh,
                                         const TriangleMesh& truth,
                                         const std::vector<TruePlane>& planes) {
  const auto surface = MakeTruthSurface(truth);
  return EvaluatePlaneAreas(SampleMesh(mesh, 1000), *surface, planes);
}

TEST(PlaneAreasTest, ShiftedSquare) {
  const auto figures = Evaluate(Square(2, 0.03, 7), Square(2.4, 0, 5, -0.2), {Level(0)});
  ASSERT_TRUE(figures.has_value());
  EXPECT_NEAR(figures->rmse_m, 0.03, 1e-9);
  EXPECT_EQ(figures->left_out, 0);
  EXPECT_NEAR(static_cast<double>(figures->num_samples), 4000, 1);
}

TEST(PlaneAreasTest, AgainstACloud) {
  const auto figures =
      Evaluate(Square(2, 0.03, 7), CloudOf(Square(2.4, 0, 5, -0.2), 1000), {Level(0)});
  ASSERT_TRUE(figures.has_value());
  EXPECT_NEAR(figures->rmse_m, 0.03, 1e-6);
}

TEST(PlaneAreasTest, ALeaningSquareHasTheRmsOfItsHeights) {
  TriangleMesh mesh = Square(1, 0, 20);
  for (Vector3d& p : mesh.vertices)
    p.z() = 0.06 * p.x();
  const auto figures = Evaluate(mesh, Square(1.4, 0, 5, -0.2), {Level(0)});
  ASSERT_TRUE(figures.has_value());
  EXPECT_NEAR(figures->rmse_m, 0.06 / std::sqrt(3.0), 0.01 * 0.06);
}

TEST(PlaneAreasTest, WhatIsFarAwayIsCountedApart) {
  TriangleMesh mesh = Square(1, 0.02, 1);
  const TriangleMesh far = Square(1, 0.3, 1);
  for (const auto& [i, j, k] : far.faces)
    mesh.faces.push_back({i + 4, j + 4, k + 4});
  mesh.vertices.insert(mesh.vertices.end(), far.vertices.begin(), far.vertices.end());
  const auto figures = Evaluate(mesh, Square(1, 0, 5), {Level(0)});
  ASSERT_TRUE(figures.has_value());
  EXPECT_NEAR(figures->rmse_m, 0.02, 1e-9);
  EXPECT_NEAR(figures->left_out, 0.5, 0.01);
}

TEST(PlaneAreasTest, SurfacesOffThePlanesDoNotCount) {
  EXPECT_FALSE(Evaluate(Square(1, 0.02, 3), Square(1, 0, 5), {Level(1)}).has_value());
  EXPECT_FALSE(Evaluate(Square(1, 0.02, 3), Square(1, 0, 5), {}).has_value());
}

}  // namespace
}  // namespace facet
