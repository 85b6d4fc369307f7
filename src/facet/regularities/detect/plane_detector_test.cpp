// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/detect/plane_detector.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "facet/geometry/angles.h"
#include "facet/testing/regularities/test_scene.h"

namespace facet {
namespace {

using testing::MakeFaces;
using testing::MakeFloor;
using testing::MakeWall;
using testing::Patch;
using testing::TestView;
using testing::Turned;

std::vector<PlaneCandidate> Detect(const SurfaceFaces& faces,
                                   const DetectionOptions& options = {}) {
  PlaneDetector detector(options);
  return detector.Detect(faces, std::vector<char>(faces.faces.size(), 0));
}

TestView ViewAt(const Vector3d& camera_W, std::uint64_t seed = 1) {
  TestView view;
  view.camera_W = camera_W;
  view.seed = seed;
  return view;
}

int CountOf(const std::vector<PlaneCandidate>& found, PlaneOrientation orientation) {
  return static_cast<int>(std::count_if(found.begin(), found.end(), [&](const auto& candidate) {
    return candidate.orientation == orientation;
  }));
}

void ExpectSweepFindsEveryWall(const Vector3d& viewer_W) {
  int num_remnants = 0;  // planes of the few faces beyond the gate
  for (int degree = 0; degree <= 180; ++degree) {
    const double azimuth = degree * kDegree;
    const Vector3d n(std::cos(azimuth), std::sin(azimuth), 0);
    TestView view = ViewAt(viewer_W, 100 + degree);
    view.sigma_depth_m = 0.015;
    const auto found = Detect(MakeFaces({MakeWall(viewer_W + 3 * n, azimuth, 4, 2.5)}, view));
    ASSERT_GE(found.size(), 1u) << degree;
    num_remnants += static_cast<int>(found.size()) - 1;
    EXPECT_GT(found[0].area_m2, 8) << degree;
    EXPECT_EQ(found[0].orientation, PlaneOrientation::kVertical) << degree;
    const Vector3d& m = found[0].plane_W.n;
    EXPECT_LT(std::atan2(std::abs(n.cross(m).z()), std::abs(n.dot(m))), 1 * kDegree) << degree;
    EXPECT_NEAR(found[0].plane_W.SignedDistance(viewer_W + 3 * n), 0, 0.03) << degree;
  }
  EXPECT_LE(num_remnants, 2);
}

TEST(PlaneDetectorTest, FindsWallsOfEveryAzimuth) {
  ExpectSweepFindsEveryWall({0, 0, 1});
}

TEST(PlaneDetectorTest, FindsThemFiftyMetresFromTheOrigin) {
  ExpectSweepFindsEveryWall({50, -50, 20});
}

TEST(PlaneDetectorTest, FindsFloorsOfEveryHeight) {
  for (const double moved : {0.0, 50.0}) {
    for (double height = -1.5; height < 0.8; height += 0.037) {
      TestView view = ViewAt({moved, moved, moved + 1.5});
      view.sigma_depth_m = 0.02;
      const auto found =
          Detect(MakeFaces({MakeFloor({moved + 1, moved, moved + height}, 2, 2)}, view));
      ASSERT_EQ(found.size(), 1u) << height;
      EXPECT_EQ(found[0].orientation, PlaneOrientation::kHorizontal) << height;
      EXPECT_NEAR(found[0].centroid_W.z(), moved + height, 0.01) << height;
    }
  }
}

// A box of 30 by 20 cm, as one holds a camera over it and as one walks by.
TEST(PlaneDetectorTest, FindsWhatFillsTheViewHoweverSmall) {
  Patch level = MakeFloor({0.1, 0, 0}, 0.3, 0.2);
  Patch leaning = Turned(level, Vector3d::UnitY(), 35 * kDegree);
  level.step_m = leaning.step_m = 0.04;
  for (const Patch& patch : {level, leaning}) {
    TestView view = ViewAt({0, 0, 0.5});
    view.sigma_depth_m = 0.002;
    const auto found = Detect(MakeFaces({patch}, view));
    ASSERT_EQ(found.size(), 1u);
    EXPECT_NEAR(found[0].area_m2, 0.06, 0.01);
    EXPECT_LT(AngleBetween(found[0].plane_W.n, patch.ToPlane().n), 2 * kDegree);
    EXPECT_TRUE(Detect(MakeFaces({patch}, ViewAt({0, 0, 2}))).empty());
  }
}

// A wall of a hall, whose points are known to decimetres there.
TEST(PlaneDetectorTest, FindsWallsFarAway) {
  int num_remnants = 0;  // planes of the few faces beyond the gate
  for (int seed = 1; seed <= 20; ++seed) {
    TestView view = ViewAt({0, 0, 2}, seed);
    view.sigma_depth_m = 0.1;
    Patch wall = MakeWall({12, 0, 3}, 0.2, 9, 5);
    wall.step_m = 0.9;
    const auto found = Detect(MakeFaces({wall}, view));
    ASSERT_GE(found.size(), 1u) << seed;
    num_remnants += static_cast<int>(found.size()) - 1;
    EXPECT_GT(found[0].area_m2, 25) << seed;
    EXPECT_LT(AngleBetween(found[0].plane_W.n, -wall.ToPlane().n), 4 * kDegree) << seed;
    EXPECT_NEAR(found[0].plane_W.SignedDistance(wall.centre_W), 0, 0.12) << seed;
  }
  EXPECT_LE(num_remnants, 2);
}

TEST(PlaneDetectorTest, ParallelWallsFortyCentimetresApartAreTwo) {
  for (int degree = 0; degree < 180; degree += 7) {
    const double azimuth = degree * kDegree;
    const Vector3d n(std::cos(azimuth), std::sin(azimuth), 0), along(-n.y(), n.x(), 0);
    TestView view = ViewAt({0, 0, 1}, 10 + degree);
    view.sigma_depth_m = 0.02;
    const auto found =
        Detect(MakeFaces({MakeWall(3 * n + 1 * along + Vector3d::UnitZ(), azimuth, 2, 2),
                          MakeWall(3.4 * n - 1.2 * along + Vector3d::UnitZ(), azimuth, 2, 2)},
                         view));
    ASSERT_EQ(found.size(), 2u) << degree;
    std::vector<double> distances;
    for (const PlaneCandidate& candidate : found)
      distances.push_back(std::abs(n.dot(candidate.centroid_W)));
    std::sort(distances.begin(), distances.end());
    EXPECT_NEAR(distances[0], 3, 0.03) << degree;
    EXPECT_NEAR(distances[1], 3.4, 0.03) << degree;
  }
}

// Left and right of a step in the wall, or a board before the middle of a wall.
TEST(PlaneDetectorTest, ParallelWallsTenCentimetresApartAreNeverOneBetween) {
  int num_both = 0, num_runs = 0;
  for (const double sigma_m : {0.005, 0.01, 0.02, 0.03}) {
    for (int seed = 0; seed < 20; ++seed) {
      for (const bool is_board : {false, true}) {
        TestView view = ViewAt({0, 0, 1}, 50 + seed);
        view.sigma_depth_m = sigma_m;
        const Patch near = MakeWall({3, is_board ? 0 : 1.0, 1}, 0, is_board ? 1 : 2, 1.2);
        const Patch far = MakeWall({3.1, is_board ? 0 : -1.05, 1}, 0, is_board ? 4 : 2, 2);
        DetectionOptions options;
        options.max_distance_m = 0.08;  // wide enough to reach points of the other wall
        const auto found = Detect(MakeFaces({near, far}, view), options);
        for (const PlaneCandidate& candidate : found) {
          const double x = candidate.centroid_W.x();
          EXPECT_LT(std::min(std::abs(x - 3), std::abs(x - 3.1)), 0.025)
              << "at " << x << " sigma " << sigma_m << " seed " << seed << " board " << is_board;
          EXPECT_GT(std::abs(candidate.plane_W.n.x()), std::cos(4 * kDegree));
        }
        num_both += found.size() == 2 ? 1 : 0;
        ++num_runs;
      }
    }
  }
  EXPECT_GT(num_both, num_runs / 2);
}

TEST(PlaneDetectorTest, LeaningBoardsAreNoWallsAndRampsNoFloors) {
  DetectionOptions without_oblique;
  without_oblique.oblique = false;
  for (const double degree : {9.0, 10.0, 11.0, 12.0}) {
    for (int seed = 0; seed < 10; ++seed) {
      const TestView view = ViewAt({0, 0, 1}, 70 + seed);
      const Patch board =
          Turned(MakeWall({2.5, 0, 1}, 0, 1.5, 1.5), Vector3d::UnitY(), degree * kDegree);
      const SurfaceFaces faces = MakeFaces({board}, view);
      const auto found = Detect(faces);
      ASSERT_EQ(found.size(), 1u) << degree;
      EXPECT_EQ(found[0].orientation, PlaneOrientation::kOblique) << degree;
      EXPECT_GT(std::abs(found[0].plane_W.n.dot(board.ToPlane().n)), std::cos(1 * kDegree));
      EXPECT_TRUE(Detect(faces, without_oblique).empty()) << degree;
      const Patch ramp =
          Turned(MakeFloor({1.5, 0, -0.5}, 1.5, 1.5), Vector3d::UnitY(), degree * kDegree);
      const SurfaceFaces level = MakeFaces({ramp}, view);
      EXPECT_EQ(CountOf(Detect(level), PlaneOrientation::kHorizontal), 0) << degree;
      EXPECT_EQ(CountOf(Detect(level), PlaneOrientation::kOblique), 1) << degree;
      EXPECT_TRUE(Detect(level, without_oblique).empty()) << degree;
    }
  }
}

TEST(PlaneDetectorTest, TablesOfOneHeightFarApartAreTwo) {
  const auto found = Detect(MakeFaces(
      {MakeFloor({2, -1.5, 0.7}, 1, 1), MakeFloor({2, 1.5, 0.7}, 1.5, 1)}, ViewAt({0, 0, 1.5})));
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(CountOf(found, PlaneOrientation::kHorizontal), 2);
}

TEST(PlaneDetectorTest, ClutterAndSpheresHoldNoPlane) {
  for (int seed = 1; seed <= 20; ++seed) {
    Rng rng(seed);
    SearchMesh mesh;
    mesh.focal_px = 467;
    mesh.baseline_m = 0.11;
    mesh.T_WC.p = {0, 0, 1};
    for (int i = 0; i < 300; ++i) {
      const int first = static_cast<int>(mesh.vertices.size());
      const Vector3d middle(rng.Uniform(1, 5), rng.Uniform(-2, 2), rng.Uniform(0, 2.5));
      for (int k = 0; k < 3; ++k)
        mesh.vertices.push_back(middle + 0.12 * rng.Normal3());
      mesh.faces.push_back({first, first + 1, first + 2});
    }
    mesh.sigma_depth_m.assign(mesh.vertices.size(), 0.01);
    mesh.may_vote.assign(mesh.faces.size(), 1);
    mesh.in_view = mesh.may_vote;
    SurfaceFaces faces;
    FillSurfaceFaces(mesh, faces);
    EXPECT_TRUE(Detect(faces).empty()) << seed;
  }
}

TEST(PlaneDetectorTest, ASphereHoldsNoPlane) {
  for (const double radius : {0.4, 0.7, 1.0}) {
    SearchMesh mesh = testing::MakeMesh({MakeFloor({0, 0, 0}, 3, 6)}, ViewAt({0, 0, 1}));
    // The patch wound around a sphere before the camera.
    for (Vector3d& p : mesh.vertices) {
      const double azimuth = p.y() / 6 * 2 * std::numbers::pi,
                   tilt = p.x() / 3.3 * std::numbers::pi;
      p = Vector3d(3, 0, 1) + radius * Vector3d(std::cos(tilt) * std::cos(azimuth),
                                                std::cos(tilt) * std::sin(azimuth),
                                                std::sin(tilt));
    }
    SurfaceFaces faces;
    FillSurfaceFaces(mesh, faces);
    EXPECT_TRUE(Detect(faces).empty()) << radius;
  }
}

TEST(PlaneDetectorTest, ALeaningRoofIsFoundByGrowing) {
  const Patch roof = Turned(MakeFloor({2.5, 0, 2.5}, 2, 3), Vector3d::UnitY(), 40 * kDegree);
  const SurfaceFaces faces = MakeFaces({roof}, ViewAt({0, 0, 1}));
  const auto found = Detect(faces);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].orientation, PlaneOrientation::kOblique);
  EXPECT_GT(std::abs(found[0].plane_W.n.dot(roof.ToPlane().n)), std::cos(1 * kDegree));
  EXPECT_NEAR(found[0].plane_W.SignedDistance(roof.centre_W), 0, 0.02);
  DetectionOptions options;
  options.oblique = false;
  EXPECT_TRUE(Detect(faces, options).empty());
}

TEST(PlaneDetectorTest, ASkirtingBoardIsNoPlane) {
  for (int seed = 1; seed <= 10; ++seed) {
    Patch board = MakeWall({3, 0, 0.05}, 0, 5, 0.1);
    board.step_m = 0.1;
    Patch strip = MakeFloor({3.05, 0, 0.1}, 0.1, 5);
    strip.step_m = 0.1;
    EXPECT_TRUE(Detect(MakeFaces({board, strip}, ViewAt({0, 0, 1}, seed))).empty());
  }
}

TEST(PlaneDetectorTest, ARoomIsItsSurfacesAndEachFaceHasOnePlane) {
  const SurfaceFaces faces = MakeFaces({MakeFloor({2, 0, 0}, 3, 4),
                                        MakeFloor({2, 0, 2.6}, 3, 4),
                                        MakeWall({3.5, 0, 1.3}, 0, 4, 2.4),
                                        MakeWall({2, 2, 1.3}, 90 * kDegree, 3, 2.4),
                                        MakeWall({2, -2, 1.3}, 90 * kDegree, 3, 2.4)},
                                       ViewAt({0.3, 0.2, 1.4}));
  const auto found = Detect(faces);
  EXPECT_EQ(CountOf(found, PlaneOrientation::kHorizontal), 2);
  EXPECT_EQ(CountOf(found, PlaneOrientation::kVertical), 3);
  EXPECT_EQ(found.size(), 5u);
  std::vector<int> uses(faces.faces.size(), 0);
  for (const PlaneCandidate& candidate : found) {
    for (const int f : candidate.faces)
      ++uses[f];
  }
  EXPECT_LE(*std::max_element(uses.begin(), uses.end()), 1);
}

// As published: few faces make no plane, however large they are.
TEST(PlaneDetectorTest, AMinimumOfFacesIsKept) {
  Patch coarse = MakeWall({3, 0, 1}, 0, 1.5, 1.5);
  coarse.step_m = 0.5;  // 18 faces
  Patch fine = coarse;
  fine.step_m = 0.37;  // 32 faces
  DetectionOptions options;
  EXPECT_EQ(Detect(MakeFaces({coarse}, ViewAt({0, 0, 1})), options).size(), 1u);
  options.min_faces = 20;
  EXPECT_TRUE(Detect(MakeFaces({coarse}, ViewAt({0, 0, 1})), options).empty());
  EXPECT_EQ(Detect(MakeFaces({fine}, ViewAt({0, 0, 1})), options).size(), 1u);
}

// As published: distances from the world's origin find walls there, but not far away.
TEST(PlaneDetectorTest, DistancesFromTheWorldsOriginLoseWallsFarAway) {
  DetectionOptions options;
  options.world_origin = true;
  options.oblique = false;
  int near = 0, far = 0, far_from_camera = 0;
  for (int seed = 1; seed <= 20; ++seed) {
    for (const bool is_far : {false, true}) {
      const Vector3d viewer_W = is_far ? Vector3d(5, 60, 1) : Vector3d(0, 0, 1);
      TestView view = ViewAt(viewer_W, seed);
      view.sigma_depth_m = 0.02;
      const SurfaceFaces faces =
          MakeFaces({MakeWall(viewer_W + Vector3d(3, 0, 0), 0, 2, 1.5)}, view);
      (is_far ? far : near) += static_cast<int>(Detect(faces, options).size());
      if (is_far) far_from_camera += static_cast<int>(Detect(faces).size());
    }
  }
  EXPECT_EQ(near, 20);
  EXPECT_EQ(far_from_camera, 20);
  EXPECT_LT(far, 5);
}

TEST(PlaneDetectorTest, TakenFacesAndThoseThatMayNotVoteAreLeftAlone) {
  SurfaceFaces faces = MakeFaces({MakeFloor({2, 0, 0}, 3, 3)}, ViewAt({0, 0, 1.5}));
  PlaneDetector detector{DetectionOptions()};
  EXPECT_TRUE(detector.Detect(faces, std::vector<char>(faces.faces.size(), 1)).empty());
  for (SurfaceFace& face : faces.faces)
    face.may_vote = false;
  EXPECT_TRUE(Detect(faces).empty());
  EXPECT_TRUE(Detect(SurfaceFaces()).empty());
}

TEST(PlaneDetectorTest, StrayFacesFarAwayHideNothing) {
  SearchMesh mesh = testing::MakeMesh({MakeFloor({2, 0, 0}, 3, 3), MakeWall({4, 0, 1.2}, 0, 3, 2)},
                                      ViewAt({0, 0, 1.5}));
  const double nan = std::nan("");
  for (const Vector3d& stray : {Vector3d(3, 0, -700),
                                Vector3d(900, 0, 1),
                                Vector3d(1e200, 1e200, -1e200),
                                Vector3d(nan, 0, nan)}) {
    const int first = static_cast<int>(mesh.vertices.size());
    for (const Vector3d& side : {Vector3d(0, 0, 0), Vector3d(0.3, 0, 0.001), Vector3d(0, 0.3, 0)})
      mesh.vertices.push_back(stray + side);
    mesh.faces.push_back({first, first + 1, first + 2});
    mesh.may_vote.push_back(1);
    mesh.in_view.push_back(1);
  }
  mesh.sigma_depth_m.resize(mesh.vertices.size(), 0.01);
  SurfaceFaces faces;
  FillSurfaceFaces(mesh, faces);
  const auto found = Detect(faces);
  EXPECT_EQ(CountOf(found, PlaneOrientation::kHorizontal), 1);
  EXPECT_EQ(CountOf(found, PlaneOrientation::kVertical), 1);
}

TEST(PlaneDetectorTest, WhatIsOutOfViewIsSearchedOnlyOnRequest) {
  SurfaceFaces faces = MakeFaces({MakeWall({3, 0, 1}, 0, 3, 2)}, ViewAt({0, 0, 1}));
  for (SurfaceFace& face : faces.faces)
    face.in_view = false;
  EXPECT_TRUE(Detect(faces).empty());
  DetectionOptions all;
  all.only_in_view = false;
  EXPECT_EQ(Detect(faces, all).size(), 1u);
}

}  // namespace
}  // namespace facet
