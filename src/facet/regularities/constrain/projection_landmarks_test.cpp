// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/constrain/projection_landmarks.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "facet/testing/regularities/test_scene.h"

namespace facet {
namespace {

using testing::BelievingEstimator;
using testing::MakeMesh;
using testing::MakeWall;
using testing::TestView;

const TestView kView{{0, 0, 1.4}, 0.005, 1, 0, 1};

TEST(ProjectionLandmarks, LandmarksOfAWallAreMarkedOnce) {
  const SearchMesh mesh = MakeMesh({MakeWall({3, 0, 1.4}, 0, 3, 2)}, kView);
  const MapSnapshot map = BelievingEstimator().Snapshot(mesh);
  ProjectionLandmarks search{DetectionOptions()};
  const PlaneAssignments found = search.Process(mesh, map);
  EXPECT_GT(found.projected.size(), 0.9 * static_cast<double>(map.landmarks.size()));
  EXPECT_TRUE(found.created.empty() && found.attached.empty() && found.unprojected.empty());
  EXPECT_TRUE(search.Process(mesh, map).IsEmpty());
}

TEST(ProjectionLandmarks, WhatIsNoLongerOnAPlaneIsTakenBack) {
  TestView view = kView;
  const SearchMesh wall = MakeMesh({MakeWall({3, 0, 1.4}, 0, 3, 2)}, view);
  ProjectionLandmarks search{DetectionOptions()};
  const auto marked = search.Process(wall, BelievingEstimator().Snapshot(wall)).projected;
  SearchMesh crumpled = wall;
  Rng rng(3);
  for (Vector3d& p_W : crumpled.vertices)
    p_W.x() += rng.Uniform(-0.5, 0.5);
  const PlaneAssignments found = search.Process(crumpled, BelievingEstimator().Snapshot(crumpled));
  EXPECT_GT(found.unprojected.size(), 0.9 * static_cast<double>(marked.size()));
  for (const LandmarkId id : found.unprojected)
    EXPECT_NE(std::find(marked.begin(), marked.end(), id), marked.end());
}

TEST(ProjectionLandmarks, WhatLeavesTheViewStays) {
  SearchMesh mesh = MakeMesh({MakeWall({3, 0, 1.4}, 0, 3, 2)}, kView);
  const MapSnapshot map = BelievingEstimator().Snapshot(mesh);
  ProjectionLandmarks search{DetectionOptions()};
  EXPECT_FALSE(search.Process(mesh, map).projected.empty());
  mesh.in_view.assign(mesh.faces.size(), 0);
  EXPECT_TRUE(search.Process(mesh, map).IsEmpty());
}

TEST(ProjectionLandmarks, AnEmptyMeshChangesNothing) {
  const SearchMesh wall = MakeMesh({MakeWall({3, 0, 1.4}, 0, 3, 2)}, kView);
  const MapSnapshot map = BelievingEstimator().Snapshot(wall);
  ProjectionLandmarks search{DetectionOptions()};
  search.Process(wall, map);
  EXPECT_TRUE(search.Process(SearchMesh(), map).IsEmpty());
  search.Reset();
  EXPECT_FALSE(search.Process(wall, map).projected.empty());
}

}  // namespace
}  // namespace facet
