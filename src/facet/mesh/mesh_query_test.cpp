// SPDX-License-Identifier: BSD-2-Clause
#include "facet/mesh/mesh_query.h"

#include <algorithm>
#include <limits>

#include <gtest/gtest.h>

#include "facet/base/random.h"

namespace facet {
namespace {

/// Random triangles in a cube of side 4 m about the origin.
TriangleMesh Clutter(Rng& rng, int count) {
  TriangleMesh mesh;
  for (int i = 0; i < count; ++i) {
    const Vector3d centre(rng.Uniform(-2, 2), rng.Uniform(-2, 2), rng.Uniform(-2, 2));
    for (int corner = 0; corner < 3; ++corner)
      mesh.vertices.push_back(centre + 0.3 * rng.Normal3());
    mesh.faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return mesh;
}

/// Distance along the ray to one face, by solving for it; empty beside it.
std::optional<double> Meet(const TriangleMesh& mesh,
                           int face,
                           const Vector3d& o,
                           const Vector3d& d) {
  const auto& [i, j, k] = mesh.faces[face];
  const Vector3d &a = mesh.vertices[i], u = mesh.vertices[j] - a, v = mesh.vertices[k] - a;
  Matrix3d A;
  A << u, v, -d;
  const Vector3d x = A.inverse() * (o - a);
  if (x[0] < 0 || x[1] < 0 || x[0] + x[1] > 1 || x[2] < 0) return std::nullopt;
  return x[2];
}

TEST(MeshQuery, FindsTheFirstFaceAlongEveryRay) {
  Rng rng(1);
  const TriangleMesh mesh = Clutter(rng, 300);
  const MeshQuery query(mesh);
  int hits = 0;
  for (int trial = 0; trial < 500; ++trial) {
    const Vector3d o = rng.Normal3(), d = rng.UnitVector();
    double first = std::numeric_limits<double>::infinity();
    for (int f = 0; f < 300; ++f)
      first = std::min(first, Meet(mesh, f, o, d).value_or(first));
    const auto hit = query.FirstAlongRay(o, 7.0 * d, 10);
    ASSERT_EQ(hit.has_value(), first <= 10);
    if (!hit) continue;
    ++hits;
    EXPECT_NEAR(hit->distance_m, first, 1e-9);
    EXPECT_NEAR((hit->p_W - (o + first * d)).norm(), 0, 1e-9);
  }
  EXPECT_GT(hits, 100);
}

// Lines along the sides of the boxes that the search looks at.
TEST(MeshQuery, GroundIsBelowItsOwnCorners) {
  constexpr int kSide = 9;
  TriangleMesh floor;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x)
      floor.vertices.push_back(Vector3d(x, y, 0));
  }
  for (int y = 0; y + 1 < kSide; ++y) {
    for (int x = 0; x + 1 < kSide; ++x) {
      const int i = y * kSide + x;
      floor.faces.push_back({i, i + 1, i + kSide + 1});
      floor.faces.push_back({i, i + kSide + 1, i + kSide});
    }
  }
  const MeshQuery query(floor);
  for (int y = 0; y <= 2 * (kSide - 1); ++y) {
    for (int x = 0; x <= 2 * (kSide - 1); ++x) {
      const Vector3d p(0.5 * x, 0.5 * y, 1);
      const auto hit = query.Below(p, 10);
      ASSERT_TRUE(hit) << p.transpose();
      EXPECT_NEAR(hit->distance_m, 1, 1e-12);
    }
  }
}

TEST(MeshQuery, HeightAndNearestDistance) {
  TriangleMesh floor;
  floor.vertices = {{-1, -1, 0.5}, {1, -1, 0.5}, {0, 1, 0.5}};
  floor.faces = {{0, 1, 2}};
  const MeshQuery query(floor);
  EXPECT_NEAR(query.Below({0, 0, 2}, 10)->distance_m, 1.5, 1e-12);
  EXPECT_FALSE(query.Below({0, 0, 2}, 1));
  EXPECT_FALSE(query.Below({0, 0, 0.4}, 10)) << "the floor is above";
  EXPECT_FALSE(query.Below({3, 0, 2}, 10));
  EXPECT_NEAR(query.Nearest({0, 0, 2}, 10)->distance_m, 1.5, 1e-12);
  EXPECT_NEAR(query.Nearest({-1, -2, 0.5}, 10)->distance_m, 1, 1e-12);
  EXPECT_FALSE(query.Nearest({0, 0, 9}, 1));
}

TEST(MeshQuery, AnEmptyMeshAndStrangeQuestionsHaveNoAnswer) {
  const MeshQuery empty{TriangleMesh()};
  EXPECT_FALSE(empty.FirstAlongRay({0, 0, 0}, {1, 0, 0}, 10));
  EXPECT_FALSE(empty.Nearest({0, 0, 0}, 10));
  Rng rng(2);
  const MeshQuery query(Clutter(rng, 20));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(query.FirstAlongRay({0, 0, nan}, {1, 0, 0}, 10));
  EXPECT_FALSE(query.FirstAlongRay({0, 0, 0}, {0, 0, 0}, 10));
  EXPECT_FALSE(query.Nearest({0, 0, nan}, 10));
}

}  // namespace
}  // namespace facet
