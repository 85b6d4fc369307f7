// SPDX-License-Identifier: BSD-2-Clause
// What known planes change of the horizon mesh, and what they must not change.
#include <algorithm>

#include <gtest/gtest.h>

#include "facet/mesh/mesh_snapshot.h"

namespace facet {
namespace {

constexpr std::size_t kNumTriangles = 32;  // of the wall

/// A wall of 5 x 5 points, 2 m before the camera; the sides of its triangles are 30 and 42 cm.
MeshView WallView(std::int64_t frame) {
  MeshView view;
  view.frame = FrameId{frame};
  view.focal_px = 458;
  for (int i = 0; i < 25; ++i) {
    const Vector3d p(0.3 * (i % 5) - 0.6, 0.3 * (i / 5) - 0.6, 2);
    view.points.push_back({LandmarkId{i}, p.normalized(), p, 0.01, 100});
  }
  return view;
}

MapSnapshot SnapshotOfWall(const MeshView& view) {
  MapSnapshot snapshot;
  snapshot.keyframes.push_back({view.frame, view.t, view.T_WC});
  for (const MeshPoint& point : view.points)
    snapshot.landmarks.push_back({point.id, point.p_C, 5, point.sigma_depth_m});
  return snapshot;
}

/// Every triangle of the wall is too large.
MeshOptions TooLarge() {
  MeshOptions options;
  options.faces.max_side_per_depth = 0.15;
  options.plane_rescue.enabled = false;
  return options;
}

class HorizonMeshPlanesTest : public ::testing::Test {
 protected:
  static void Update(HorizonMesh& mesh, std::int64_t frame = 0) {
    const MeshView view = WallView(frame);
    mesh.Update(view, SnapshotOfWall(view), SE3());
  }
  static SearchMesh Searched(const HorizonMesh& mesh) {
    SearchMesh searched;
    mesh.FillSearchMesh(WallView(0), searched);
    return searched;
  }
  static std::size_t NumTriangles(const HorizonMesh& mesh) {
    return Searched(mesh).triangles.size();
  }
  static MeshSnapshot Shown(const HorizonMesh& mesh) { return MakeMeshSnapshot(WallView(0), mesh); }
  // Planes that know no face say this of the triangles.
  static void Judge(HorizonMesh& mesh, const std::vector<TriangleVerdict>& verdicts) {
    mesh.Take({std::vector<int>(Searched(mesh).faces.size(), -1), {}, verdicts});
  }
  // The first `count` of all triangles.
  static std::vector<TriangleVerdict> First(std::size_t count, TriangleVerdict verdict) {
    std::vector<TriangleVerdict> out(kNumTriangles);
    std::fill_n(out.begin(), count, verdict);
    return out;
  }
};

TEST_F(HorizonMeshPlanesTest, RejectedTrianglesOnAPlaneAreShown) {
  HorizonMesh mesh(TooLarge(), true);
  Update(mesh);
  EXPECT_TRUE(mesh.faces().empty());
  ASSERT_EQ(NumTriangles(mesh), kNumTriangles);
  EXPECT_TRUE(Shown(mesh).vertex_ids.empty()) << "a vertex without a face is not shown";
  Judge(mesh, First(1, {5, false}));
  const MeshSnapshot shown = Shown(mesh);
  EXPECT_EQ(shown.mesh.plane_ids, std::vector<int>{5});
  EXPECT_EQ(shown.mesh.vertices.size(), 3u);
  EXPECT_EQ(shown.vertex_ids.size(), 3u);
  EXPECT_EQ(shown.mesh.normals.size(), 3u);
  EXPECT_EQ(shown.in_view, std::vector<char>{1});
  EXPECT_EQ(Searched(mesh).faces.size(), 0u) << "no plane confirms itself";
}

TEST_F(HorizonMeshPlanesTest, TheyStayAsLongAsTheyAreOnIt) {
  HorizonMesh mesh(TooLarge(), true);
  Update(mesh);
  Judge(mesh, First(kNumTriangles, {5, false}));
  Update(mesh, 1);
  EXPECT_EQ(mesh.faces().size(), kNumTriangles);
  // They are judged again, and so are the same triangles of the new view.
  ASSERT_EQ(NumTriangles(mesh), 2 * kNumTriangles);
  std::vector<TriangleVerdict> verdicts(2 * kNumTriangles);
  verdicts[3] = verdicts[kNumTriangles + 3] = {6, false};
  verdicts[kNumTriangles + 4] = {7, false};
  Judge(mesh, verdicts);
  EXPECT_EQ(Shown(mesh).mesh.plane_ids, (std::vector<int>{6, 7}));
  mesh.Clear();
  ASSERT_EQ(mesh.expired().size(), 2u) << "the map gets them";
  EXPECT_EQ(mesh.expired()[0].plane_id, 6);
}

TEST_F(HorizonMeshPlanesTest, BridgesAreHiddenAndNothingElse) {
  HorizonMesh mesh(MeshOptions(), true);
  Update(mesh);
  ASSERT_EQ(mesh.faces().size(), kNumTriangles);
  Judge(mesh, First(3, {-1, true}));
  EXPECT_EQ(Shown(mesh).mesh.faces.size(), kNumTriangles - 3);
  EXPECT_EQ(Searched(mesh).faces.size(), kNumTriangles);
  EXPECT_EQ(mesh.faces().size(), kNumTriangles);
  Judge(mesh, First(0, {}));
  EXPECT_EQ(Shown(mesh).mesh.faces.size(), kNumTriangles);
}

// Half of a bridge's area is near some surface: without bridges the map misses a point of it.
TEST_F(HorizonMeshPlanesTest, TheMapGetsWhatIsHidden) {
  HorizonMesh mesh(MeshOptions(), true);
  Update(mesh);
  Judge(mesh, First(3, {-1, true}));
  mesh.Clear();
  EXPECT_EQ(mesh.expired().size(), kNumTriangles);
}

TEST_F(HorizonMeshPlanesTest, NothingIsKeptForPlanesThatDoNotJudge) {
  HorizonMesh mesh(TooLarge());
  Update(mesh);
  EXPECT_EQ(NumTriangles(mesh), 0u);
  EXPECT_TRUE(mesh.vertices().empty());
}

// A triangle that is too narrow would be taken away again at once.
TEST_F(HorizonMeshPlanesTest, TheShapeOfATriangleIsJudgedByNoPlane) {
  MeshOptions options = TooLarge();
  options.faces.max_side_m = 0.4;
  HorizonMesh mesh(options, true);
  Update(mesh);
  EXPECT_EQ(NumTriangles(mesh), 0u);
}

}  // namespace
}  // namespace facet
