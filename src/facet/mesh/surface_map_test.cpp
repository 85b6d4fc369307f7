// SPDX-License-Identifier: BSD-2-Clause
#include "facet/mesh/surface_map.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <optional>
#include <set>

#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/mesh/hole_filling.h"
#include "facet/mesh/map_follower.h"

namespace facet {
namespace {

ExpiredFace FaceOf(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  ExpiredFace face;
  face.p_W = {a, b, c};
  face.intensity = {50, 100, 150};
  face.sigma_depth_m = 0.02;
  face.is_boundary = {true, true, true};
  return face;
}

/// Surfaces that end where their faces end: three quarters of a voxel further, as only whole cells
/// of the grid are extracted.
SurfaceMapOptions EndingWithTheFaces() {
  SurfaceMapOptions options;
  options.boundary_m = 0.75 * options.voxel_m;
  options.boundary_weight = 1;
  return options;
}

/// A square floor of side 2 m at height z, in `cells` x `cells` squares of two faces each; the
/// camera is above it.
void AddFloor(double z,
              double noise,
              Rng& rng,
              SurfaceMap& map,
              int cells = 8,
              const std::optional<Vector3d>& eye_W = std::nullopt) {
  std::vector<Vector3d> p;
  for (int y = 0; y <= cells; ++y) {
    for (int x = 0; x <= cells; ++x)
      p.push_back({2.0 * x / cells - 1, 2.0 * y / cells - 1, z + noise * rng.Normal()});
  }
  for (int y = 0; y < cells; ++y) {
    for (int x = 0; x < cells; ++x) {
      const int i = y * (cells + 1) + x;
      for (ExpiredFace face : {FaceOf(p[i], p[i + 1], p[i + cells + 2]),
                               FaceOf(p[i], p[i + cells + 2], p[i + cells + 1])}) {
        face.eye_W = eye_W;
        map.Add(face);
      }
    }
  }
}

double AreaOf(const TriangleMesh& mesh) {
  double area = 0;
  for (const auto& [i, j, k] : mesh.faces) {
    const Vector3d& a = mesh.vertices[i];
    area += 0.5 * (mesh.vertices[j] - a).cross(mesh.vertices[k] - a).norm();
  }
  return area;
}

TEST(SurfaceMap, AFloorComesBackWhereItWasAndLooksUp) {
  Rng rng(1);
  for (double z : {0.0, 0.031, -1.2345}) {
    SurfaceMap map{EndingWithTheFaces()};
    AddFloor(z, 0, rng, map);
    const TriangleMesh mesh = ExtractSurface(map);
    EXPECT_NEAR(AreaOf(mesh), 4, 0.3);
    for (const Vector3d& p : mesh.vertices)
      ASSERT_NEAR(p.z(), z, 1e-5);
    for (const Vector3d& n : mesh.normals)
      ASSERT_GT(n.z(), 0.999);
    for (const auto& colour : mesh.colours)
      ASSERT_TRUE(colour[0] >= 49 && colour[0] <= 151);
  }
}

TEST(SurfaceMap, AnotherMapFollowsByWhatHasChangedAndItsPartsAreTheWhole) {
  SurfaceMapOptions options = EndingWithTheFaces();
  options.max_hole_m = 0;
  SurfaceMap map(options);
  MapFollower follower(options);
  Rng rng(1);
  for (double z : {0.03, 1.0}) {
    AddFloor(z, 0, rng, map, 8, Vector3d(0, 0, 3));
    const std::vector<SurfaceMap::Block> first = map.TakeChanged(3);
    EXPECT_EQ(first.size(), 3u);
    follower.Take(first);
    follower.Take(map.TakeChanged(1000000));
    EXPECT_TRUE(map.TakeChanged(1000000).empty());
  }
  std::size_t num_faces = 0, num_shown = 0;
  EXPECT_TRUE(follower.has_changed());
  while (const auto part = follower.TakePart()) {
    const TriangleMesh& mesh = part->mesh;
    num_faces += mesh.faces.size();
    num_shown += mesh.faces.empty() ? 0 : 1;
    EXPECT_EQ(mesh.plane_ids.size(), mesh.faces.size());
    EXPECT_EQ(mesh.normals.size(), mesh.vertices.size());
  }
  EXPECT_FALSE(follower.has_changed());
  EXPECT_GT(num_shown, 3u);
  EXPECT_EQ(num_faces, ExtractSurface(map).faces.size());
  follower.MarkAll();
  std::size_t num_again = 0;
  while (const auto part = follower.TakePart())
    num_again += part->mesh.faces.size();
  EXPECT_EQ(num_again, num_faces) << "for whoever comes late";
}

TEST(SurfaceMap, PartsOfNegativeBlocksAreAsLargeAsOthers) {
  EXPECT_EQ(PartOf({-1, -4, -5}), (CubeIndex{-1, -1, -2}));
  EXPECT_EQ(PartOf({0, 3, 4}), (CubeIndex{0, 0, 1}));
}

TEST(SurfaceMap, SlantedPlanesInEveryDirectionComeBack) {
  Rng rng(2);
  for (int trial = 0; trial < 50; ++trial) {
    const Quaterniond q(Eigen::AngleAxisd(rng.Uniform(0, 3), rng.UnitVector()));
    const Vector3d t = rng.Normal3();
    SurfaceMap map{EndingWithTheFaces()};
    const Vector3d a = q * Vector3d(-1, -1, 0) + t, b = q * Vector3d(1, -1, 0) + t,
                   c = q * Vector3d(0, 1, 0) + t, n = q * Vector3d::UnitZ();
    map.Add(FaceOf(a, b, c));
    const TriangleMesh mesh = ExtractSurface(map);
    EXPECT_NEAR(AreaOf(mesh), 2, 0.5);
    for (const Vector3d& p : mesh.vertices)
      ASSERT_NEAR(n.dot(p - t), 0, 1e-4);
    for (const auto& [i, j, k] : mesh.faces) {
      const Vector3d twice_area =
          (mesh.vertices[j] - mesh.vertices[i]).cross(mesh.vertices[k] - mesh.vertices[i]);
      if (twice_area.norm() < 1e-5) continue;  // a sliver has no direction
      ASSERT_GT(twice_area.normalized().dot(n), 0.99);
    }
  }
}

double LowestY(const SurfaceMap& map) {
  double low = 0;
  for (const Vector3d& p : ExtractSurface(map).vertices)
    low = std::min(low, p.y());
  return low;
}

TEST(SurfaceMap, ASurfaceGoesOnBeyondItsBoundaryAndOnlyThere) {
  ExpiredFace face = FaceOf({-1, -1, 0}, {1, -1, 0}, {0, 1, 0});
  const SurfaceMapOptions options;
  SurfaceMap plain{options}, grown{options}, other{options};
  face.is_boundary = {};
  plain.Add(face);
  face.is_boundary = {false, false, true};  // the side at y = -1
  grown.Add(face);
  face.is_boundary = {true, false, false};
  other.Add(face);
  EXPECT_NEAR(LowestY(plain), -1, 1.01 * options.voxel_m);
  EXPECT_NEAR(LowestY(grown), -1 - options.boundary_m, options.voxel_m);
  EXPECT_DOUBLE_EQ(LowestY(other), LowestY(plain));
  for (const Vector3d& p : ExtractSurface(grown).vertices)
    ASSERT_NEAR(p.z(), 0, 1e-5);
}

TEST(SurfaceMap, ARimWithoutWeightIsNoRim) {
  for (const double weight : {0.0, 1e-60}) {  // as a float both are nothing
    SurfaceMapOptions options;
    options.boundary_weight = weight;
    const auto area = [&](bool is_boundary) {
      SurfaceMap map(options);
      ExpiredFace small = FaceOf({-1, -1, 0}, {1, -1, 0}, {0, 1, 0});
      small.is_boundary.fill(is_boundary);
      map.Add(small);
      map.Add(FaceOf({-2, -2, 0}, {2, -2, 0}, {0, 2, 0}));
      return AreaOf(ExtractSurface(map));
    };
    EXPECT_GT(area(false), 7);
    EXPECT_EQ(area(true), area(false)) << weight;
  }
}

TEST(SurfaceMap, WhatWasSeenCountsMoreThanWhatWasExpected) {
  // The floor ends at y = -1 as far as it was seen; beyond that it is 4 cm lower.
  ExpiredFace floor = FaceOf({-1, -1, 0}, {1, -1, 0}, {0, 1, 0});
  floor.is_boundary = {false, false, true};
  const ExpiredFace step = FaceOf({-1.5, -0.9, -0.04}, {0, -3, -0.04}, {1.5, -0.9, -0.04});
  const SurfaceMapOptions options;
  SurfaceMap map{options};
  map.Add(floor);
  map.Add(step);
  int beyond = 0;
  for (const Vector3d& p : ExtractSurface(map).vertices) {
    if (p.y() > -1.1 || std::abs(p.x()) > 0.8) continue;
    EXPECT_LT(p.z(), -0.04 / (1 + options.boundary_weight) + 1e-3) << p.transpose();
    EXPECT_GT(p.z(), -0.041) << p.transpose();
    ++beyond;
  }
  EXPECT_GT(beyond, 20);
}

TEST(SurfaceMap, ReturningWithDriftMakesOneSurfaceAndNoMoreMemory) {
  Rng rng(3);
  SurfaceMap map{EndingWithTheFaces()};
  AddFloor(0, 0.01, rng, map);
  const double area_m2 = AreaOf(ExtractSurface(map));
  const std::size_t blocks = map.blocks().size();
  AddFloor(0.04, 0.01, rng, map);
  EXPECT_NEAR(AreaOf(ExtractSurface(map)), area_m2, 0.05 * area_m2);
  for (int lap = 0; lap < 20; ++lap)
    AddFloor(0.02, 0.01, rng, map);
  EXPECT_LT(10 * map.blocks().size(), 13 * blocks);
  for (const Vector3d& p : ExtractSurface(map).vertices)
    EXPECT_NEAR(p.z(), 0.02, 0.02);
}

TEST(SurfaceMap, GrowsNoMoreWhenItIsFullAndIsStillImproved) {
  Rng rng(5);
  SurfaceMapOptions options = EndingWithTheFaces();
  SurfaceMap large(options);
  AddFloor(0, 0, rng, large);
  EXPECT_FALSE(large.memory().is_full);
  options.max_memory_mb = 0.5 * large.memory().used_mb;
  SurfaceMap small(options);
  for (int lap = 0; lap < 20; ++lap)
    AddFloor(lap == 0 ? 0.05 : 0.0, 0, rng, small);
  EXPECT_TRUE(small.memory().is_full);
  EXPECT_LE(small.memory().used_mb, options.max_memory_mb);
  const TriangleMesh mesh = ExtractSurface(small);
  EXPECT_GT(AreaOf(mesh), 1);
  EXPECT_LT(AreaOf(mesh), 3);
  for (const Vector3d& p : mesh.vertices)
    ASSERT_NEAR(p.z(), 0, 0.01);
}

TEST(SurfaceMap, ParallelSurfacesFarApartStayTwo) {
  Rng rng(4);
  SurfaceMap map{EndingWithTheFaces()};
  AddFloor(0, 0, rng, map);
  AddFloor(0.72, 0, rng, map);
  EXPECT_NEAR(AreaOf(ExtractSurface(map)), 8, 0.6);
}

// A wrong face hangs between the camera and a floor; the floor was seen through it.
TEST(SurfaceMap, CarvesWhatItsCameraSawThrough) {
  const auto wrong_vertices = [](const SurfaceMapOptions& options) {
    Rng rng(6);
    SurfaceMap map(options);
    map.Add(FaceOf({-0.5, -0.5, 1.1}, {0.5, -0.5, 1}, {0, 0.5, 1.2}));
    for (int view = 0; view < 10; ++view)
      AddFloor(0, 0.005, rng, map, 8, Vector3d(0.05 * view, 0.03 * view, 2));
    const TriangleMesh mesh = ExtractSurface(map);
    EXPECT_GT(AreaOf(mesh), 3.8);
    return std::count_if(
        mesh.vertices.begin(), mesh.vertices.end(), [](const Vector3d& p) { return p.z() > 0.5; });
  };
  SurfaceMapOptions options = EndingWithTheFaces();
  const auto carved = wrong_vertices(options);
  options.carving_weight = 0;
  EXPECT_LT(10 * carved, wrong_vertices(options));
}

// Faces that are too small for a sight line of their own share them.
TEST(SurfaceMap, SmallFacesCarveTogether) {
  const auto highest = [](const SurfaceMapOptions& options) {
    Rng rng(7);
    SurfaceMap map(options);
    map.Add(FaceOf({-0.5, -0.5, 1.1}, {0.5, -0.5, 1}, {0, 0.5, 1.2}));
    constexpr int kCells = 32;  // of 6 cm: each face has 5 % of the area of one sight line
    for (int view = 0; view < 10; ++view)
      AddFloor(0, 0.002, rng, map, kCells, Vector3d(0.05 * view, 0.03 * view, 2));
    double z = -1;
    for (const Vector3d& p : ExtractSurface(map).vertices)
      z = std::max(z, p.z());
    return z;
  };
  SurfaceMapOptions options = EndingWithTheFaces();
  EXPECT_LT(highest(options), 0.1);
  options.carving_weight = 0;
  EXPECT_GT(highest(options), 1);
}

// A large face elsewhere leaves no sight lines to the small one after it.
TEST(SurfaceMap, ASmallFaceIsLookedThroughOnceAtMost) {
  for (double side = 0.25; side < 4; side += 0.25) {
    SurfaceMapOptions options = EndingWithTheFaces();
    SurfaceMap map(options);
    const ExpiredFace wall = FaceOf({-0.5, -0.5, 1}, {0.5, -0.5, 1}, {0, 0.5, 1});
    for (int i = 0; i < 3; ++i)
      map.Add(wall);
    const double area = AreaOf(ExtractSurface(map));
    ExpiredFace far = FaceOf({100, 0, 0}, {100 + side, 0, 0}, {100, side, 0});
    far.eye_W = Vector3d(100, 0, 5);
    map.Add(far);
    const double with_far = AreaOf(ExtractSurface(map));
    ExpiredFace near = FaceOf({0, 0, 0}, {0.06, 0, 0}, {0, 0.06, 0});
    near.eye_W = Vector3d(0, 0, 2);
    map.Add(near);
    // One sight line takes 1 of 3 from what it meets: nothing goes.
    EXPECT_GT(with_far, area - 1e-9);
    EXPECT_GT(AreaOf(ExtractSurface(map)), with_far - 1e-9) << side;
  }
}

/// Walls that meet at a right angle, seen 50 times from 1 m beside one of them.
double AreaOfTwoWalls(const SurfaceMapOptions& options) {
  SurfaceMap map(options);
  for (int view = 0; view < 50; ++view) {
    for (int i = 0; i < 8; ++i) {
      const double y = 0.5 * i, x = 0.25 * i;
      for (ExpiredFace face : {FaceOf({0, y, 0}, {0, y + 0.5, 0}, {0, y + 0.5, 2}),
                               FaceOf({0, y, 0}, {0, y + 0.5, 2}, {0, y, 2}),
                               FaceOf({x, 4, 0}, {x + 0.25, 4, 0}, {x, 4, 2}),
                               FaceOf({x + 0.25, 4, 0}, {x + 0.25, 4, 2}, {x, 4, 2})}) {
        face.eye_W = Vector3d(1, 0, 1.2);
        map.Add(face);
      }
    }
  }
  return AreaOf(ExtractSurface(map));
}

TEST(SurfaceMap, CarvingLeavesWallsBesideTheSightLinesAlone) {
  SurfaceMapOptions options = EndingWithTheFaces();
  const double carved_m2 = AreaOfTwoWalls(options);
  options.carving_weight = 0;
  const double whole_m2 = AreaOfTwoWalls(options);
  EXPECT_GT(whole_m2, 10);
  EXPECT_NEAR(carved_m2, whole_m2, 0.01 * whole_m2);
}

TEST(SurfaceMap, NoSightLineIsTooStrange) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  SurfaceMap map{EndingWithTheFaces()};
  ExpiredFace face = FaceOf({-1, -1, 0}, {1, -1, 0}, {0, 1, 0});
  map.Add(face);
  for (const Vector3d& eye : {Vector3d(nan, 0, 1),
                              Vector3d(0, 0, 1e300),
                              Vector3d(0, 0, 0),
                              Vector3d(-1. / 3, -1. / 3, 0),
                              Vector3d(0, 0, -1e6)}) {
    face.eye_W = eye;
    map.Add(face);
  }
  EXPECT_FALSE(ExtractSurface(map).faces.empty());
}

/// Of a board that is seen equally often from above and from below.
double AreaOfBoard(double thickness_m) {
  Rng rng(9);
  SurfaceMap map{EndingWithTheFaces()};
  for (int view = 0; view < 10; ++view) {
    for (int x = 0; x < 8; ++x) {
      const auto corner = [&](double dx, double y) {
        return Vector3d(0.25 * (x + dx) - 1, y, 0.04 + 0.003 * rng.Normal());
      };
      for (ExpiredFace face : {FaceOf(corner(0, -1), corner(1, -1), corner(1, 1)),
                               FaceOf(corner(0, -1), corner(1, 1), corner(0, 1))}) {
        map.Add(face);
        std::swap(face.p_W[1], face.p_W[2]);
        for (Vector3d& p : face.p_W)
          p.z() -= thickness_m;
        map.Add(face);
      }
    }
  }
  return AreaOf(ExtractSurface(map));
}

TEST(SurfaceMap, ThinThingsStay) {
  for (const double thickness_m : {0.02, 0.05, 0.1})
    EXPECT_NEAR(AreaOfBoard(thickness_m), 4, 0.2) << thickness_m;
}

TEST(SurfaceMap, FacesSeenFromBehindAreLeftOut) {
  SurfaceMap map{EndingWithTheFaces()};
  ExpiredFace face = FaceOf({-0.5, -0.5, 0}, {0.5, -0.5, 0}, {0, 0.5, 0});
  face.eye_W = Vector3d(0, 0, -2);
  map.Add(face);
  EXPECT_TRUE(map.blocks().empty());
}

TEST(SurfaceMap, FacesHaveAreaAndAreThereOnce) {
  Rng rng(8);
  SurfaceMap map{EndingWithTheFaces()};
  for (int i = 0; i < 400; ++i) {
    const Vector3d a(rng.Uniform(-1, 1), rng.Uniform(-1, 1), rng.Uniform(-1, 1));
    map.Add(FaceOf(a, a + 0.5 * rng.Normal3(), a + 0.5 * rng.Normal3()));
  }
  const TriangleMesh mesh = ExtractSurface(map);
  ASSERT_GT(mesh.faces.size(), 1000u);
  std::set<std::array<int, 3>> faces;
  std::set<int> used;
  for (std::array<int, 3> face : mesh.faces) {
    const Vector3d& a = mesh.vertices[face[0]];
    EXPECT_GT((mesh.vertices[face[1]] - a).cross(mesh.vertices[face[2]] - a).norm(), 0);
    used.insert(face.begin(), face.end());
    std::sort(face.begin(), face.end());
    EXPECT_TRUE(faces.insert(face).second);
  }
  EXPECT_EQ(used.size(), mesh.vertices.size());
}

TEST(SurfaceMap, PlaneIdsReachTheFaces) {
  SurfaceMap map{EndingWithTheFaces()};
  ExpiredFace face = FaceOf({-1, -1, 0}, {1, -1, 0}, {0, 1, 0});
  face.plane_id = 7;
  map.Add(face);
  const TriangleMesh mesh = ExtractSurface(map);
  ASSERT_EQ(mesh.plane_ids.size(), mesh.faces.size());
  for (int id : mesh.plane_ids)
    EXPECT_EQ(id, 7);
}

TEST(SurfaceMap, IgnoresFacesThatAreNoFaces) {
  SurfaceMap map{EndingWithTheFaces()};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  map.Add(FaceOf({0, 0, nan}, {1, 0, 0}, {0, 1, 0}));
  map.Add(FaceOf({0, 0, 1e300}, {1, 0, 0}, {0, 1, 0}));
  map.Add(FaceOf({0, 0, 0}, {1, 0, 0}, {2, 0, 0}));
  map.Add(FaceOf({0, 0, 0}, {0, 0, 0}, {0, 0, 0}));
  EXPECT_TRUE(map.blocks().empty());
  EXPECT_TRUE(ExtractSurface(map).faces.empty());
}

/// A grid of squares of 0.1 m, without those for which `is_open`.
TriangleMesh Sheet(int cells, const std::function<bool(int, int)>& is_open) {
  TriangleMesh mesh;
  for (int y = 0; y <= cells; ++y) {
    for (int x = 0; x <= cells; ++x)
      mesh.vertices.push_back({0.1 * x, 0.1 * y, 0});
  }
  for (int y = 0; y < cells; ++y) {
    for (int x = 0; x < cells; ++x) {
      if (is_open(x, y)) continue;
      const int i = y * (cells + 1) + x;
      mesh.faces.push_back({i, i + 1, i + cells + 2});
      mesh.faces.push_back({i, i + cells + 2, i + cells + 1});
    }
  }
  mesh.plane_ids.assign(mesh.faces.size(), 3);
  return mesh;
}

TEST(HoleFilling, ClosesAPlaneHoleAndNotTheOutside) {
  TriangleMesh mesh = Sheet(8, [](int x, int y) { return x >= 3 && x < 6 && y >= 2 && y < 4; });
  EXPECT_NEAR(AreaOf(mesh), 0.58, 1e-9);
  EXPECT_EQ(CloseHoles(10, 0.02, mesh), 1);
  EXPECT_NEAR(AreaOf(mesh), 0.64, 1e-9);
  EXPECT_EQ(mesh.plane_ids.size(), mesh.faces.size());
  EXPECT_EQ(mesh.plane_ids.back(), 3);
  for (const auto& [i, j, k] : mesh.faces) {
    const Vector3d& a = mesh.vertices[i];
    EXPECT_GT((mesh.vertices[j] - a).cross(mesh.vertices[k] - a).z(), 0);
  }
  EXPECT_EQ(CloseHoles(10, 0.02, mesh), 0);
}

TEST(HoleFilling, LeavesLargeAndUnevenHolesOpen) {
  const auto open = [](int x, int y) { return x >= 2 && x < 6 && y >= 2 && y < 6; };
  TriangleMesh mesh = Sheet(8, open);
  EXPECT_EQ(CloseHoles(1.5, 0.02, mesh), 0);
  mesh.vertices[2 * 9 + 3].z() = 0.3;
  EXPECT_EQ(CloseHoles(10, 0.02, mesh), 0);
}

TEST(HoleFilling, ClosesAConcaveHole) {
  TriangleMesh mesh = Sheet(
      8, [](int x, int y) { return (x >= 2 && x < 6 && y == 2) || (x == 2 && y >= 2 && y < 6); });
  EXPECT_EQ(CloseHoles(10, 0.02, mesh), 1);
  EXPECT_NEAR(AreaOf(mesh), 0.64, 1e-9);
}

}  // namespace
}  // namespace facet
