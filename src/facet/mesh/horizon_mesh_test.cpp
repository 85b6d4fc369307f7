// SPDX-License-Identifier: BSD-2-Clause
#include "facet/mesh/horizon_mesh.h"

#include <algorithm>
#include <limits>
#include <set>

#include <gtest/gtest.h>

#include "facet/base/random.h"

namespace facet {
namespace {

constexpr double kFocal_px = 458;

MeshPoint PointAt(std::int64_t id, const Vector3d& p_C, double sigma_m = 0.01) {
  return {LandmarkId{id}, p_C.normalized(), p_C, sigma_m, 100};
}

/// A view from the origin of W along its z axis.
MeshView ViewOf(std::vector<MeshPoint> points, std::int64_t frame = 0) {
  MeshView view;
  view.frame = FrameId{frame};
  view.focal_px = kFocal_px;
  view.points = std::move(points);
  return view;
}

/// As in the paper: faces leave with their landmarks.
MeshOptions StrictHorizon() {
  MeshOptions options;
  options.horizon_s = 0;
  return options;
}

/// The snapshot in which every point of the view is a landmark.
MapSnapshot SnapshotOf(const MeshView& view) {
  MapSnapshot snapshot;
  snapshot.keyframes.push_back({view.frame, view.t, view.T_WC});
  for (const MeshPoint& point : view.points) {
    if (!IsSupport(point.id) && point.id.IsValid())
      snapshot.landmarks.push_back({point.id, view.T_WC * point.p_C, 5, point.sigma_depth_m});
  }
  std::sort(snapshot.landmarks.begin(), snapshot.landmarks.end(), [](const auto& a, const auto& b) {
    return a.id < b.id;
  });
  return snapshot;
}

/// What HorizonMesh promises between calls.
void ExpectInvariants(const HorizonMesh& mesh, const MapSnapshot& snapshot) {
  std::set<LandmarkId> known;
  for (const LandmarkEstimate& landmark : snapshot.landmarks)
    known.insert(landmark.id);
  std::set<FrameId> keyframes;
  for (const KeyframePose& keyframe : snapshot.keyframes)
    keyframes.insert(keyframe.id);
  std::vector<char> is_used(mesh.vertices().size(), 0);
  for (std::size_t i = 0; i < mesh.vertices().size(); ++i) {
    const MeshVertex& vertex = mesh.vertices()[i];
    ASSERT_TRUE(vertex.p_W.allFinite());
    ASSERT_TRUE(IsSupport(vertex.id) ? keyframes.count(vertex.host) : known.count(vertex.id));
    if (i > 0) {
      ASSERT_LT(mesh.vertices()[i - 1].id, vertex.id);
    }
  }
  for (std::size_t f = 0; f < mesh.faces().size(); ++f) {
    const auto& corners = mesh.faces()[f].corners;
    ASSERT_LT(corners[0], corners[1]);
    ASSERT_LT(corners[1], corners[2]);
    ASSERT_LT(corners[2], static_cast<int>(mesh.vertices().size()));
    if (f > 0) {
      ASSERT_LT(mesh.faces()[f - 1].corners, corners) << "not sorted or twice";
    }
    for (int corner : corners)
      is_used[corner] = 1;
  }
  ASSERT_EQ(std::count(is_used.begin(), is_used.end(), 0), 0);
}

void ExpectNormalsTowards(const HorizonMesh& mesh, const Vector3d& camera_W) {
  for (const MeshFace& face : mesh.faces()) {
    if (!face.in_view) continue;
    const auto [a, b, c] = face.CounterClockwise();
    const Vector3d& p = mesh.vertices()[a].p_W;
    const Vector3d n = (mesh.vertices()[b].p_W - p).cross(mesh.vertices()[c].p_W - p);
    ASSERT_GT(n.dot(camera_W - p), 0);
  }
}

std::vector<MeshPoint> WallPoints(double z_m) {
  std::vector<MeshPoint> points;
  for (int i = 0; i < 25; ++i)
    points.push_back(PointAt(i, {0.3 * (i % 5) - 0.6, 0.3 * (i / 5) - 0.6, z_m}));
  return points;
}

TEST(HorizonMesh, CoversAWallAndLooksAtTheCamera) {
  HorizonMesh mesh{MeshOptions()};
  const MeshView view = ViewOf(WallPoints(2));
  mesh.Update(view, SnapshotOf(view), SE3());
  EXPECT_EQ(mesh.faces().size(), 32u);
  ExpectInvariants(mesh, SnapshotOf(view));
  ExpectNormalsTowards(mesh, Vector3d::Zero());
  const TriangleMesh plain = mesh.ToTriangleMesh();
  for (const Vector3d& n : plain.normals)
    EXPECT_NEAR((n - Vector3d(0, 0, -1)).norm(), 0, 1e-9);
  EXPECT_TRUE(std::all_of(
      mesh.faces().begin(), mesh.faces().end(), [](const MeshFace& f) { return f.may_vote; }));
}

TEST(HorizonMesh, ExpiredFacesKnowTheBoundaryOfTheirSurface) {
  HorizonMesh mesh{MeshOptions()};
  const MeshView view = ViewOf(WallPoints(2));
  mesh.Update(view, SnapshotOf(view), SE3());
  mesh.Clear();
  ASSERT_EQ(mesh.expired().size(), 32u);
  const auto on_same_border = [](const Vector3d& a, const Vector3d& b) {
    return (std::abs(a.x()) > 0.59 && std::abs(a.x() - b.x()) < 0.01) ||
           (std::abs(a.y()) > 0.59 && std::abs(a.y() - b.y()) < 0.01);
  };
  int boundaries = 0;
  for (const ExpiredFace& face : mesh.expired()) {
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_EQ(face.is_boundary[i], on_same_border(face.p_W[(i + 1) % 3], face.p_W[(i + 2) % 3]));
      boundaries += face.is_boundary[i] ? 1 : 0;
    }
  }
  EXPECT_EQ(boundaries, 16);
}

TEST(HorizonMesh, FacesThatNewerOnesCoverHaveNoBoundary) {
  HorizonMesh mesh{MeshOptions()};
  MeshView view = ViewOf(WallPoints(2));
  mesh.Update(view, SnapshotOf(view), SE3());
  std::vector<MeshPoint> others = WallPoints(2);
  for (MeshPoint& point : others)
    point.id.value += 100;
  view = ViewOf(others, 1);
  mesh.Update(view, SnapshotOf(view), SE3());
  EXPECT_EQ(mesh.faces().size(), 32u);
  ASSERT_EQ(mesh.expired().size(), 32u);
  for (const ExpiredFace& face : mesh.expired())
    EXPECT_EQ(face.is_boundary, (std::array<bool, 3>{}));
}

TEST(HorizonMesh, FacesOfALandmarkThatLeftTheHorizonLeaveToo) {
  HorizonMesh mesh(StrictHorizon());
  const MeshView view = ViewOf(WallPoints(2));
  mesh.Update(view, SnapshotOf(view), SE3());
  MapSnapshot later = SnapshotOf(view);
  later.landmarks.erase(later.landmarks.begin() + 12);  // the centre of the wall
  mesh.Update(ViewOf({}, 1), later, SE3());
  ExpectInvariants(mesh, later);
  EXPECT_EQ(mesh.faces().size() + mesh.expired().size(), 32u);
  EXPECT_GE(mesh.expired().size(), 4u);
}

TEST(HorizonMesh, ForgottenFacesStayForTheHorizonAndNotLonger) {
  MeshOptions options;
  options.horizon_s = 5;
  HorizonMesh mesh(options);
  const MeshView view = ViewOf(WallPoints(2));
  mesh.Update(view, SnapshotOf(view), SE3());
  for (int second = 1; second <= 6; ++second) {
    MeshView empty = ViewOf({}, second);
    empty.t = view.t + FromSeconds(second);
    mesh.Update(empty, MapSnapshot(), SE3());
    EXPECT_EQ(mesh.faces().size(), second < 5 ? 32u : 0u);
    EXPECT_EQ(mesh.expired().size(), second == 5 ? 32u : 0u);
  }
}

TEST(HorizonMesh, VerticesFollowTheEstimates) {
  HorizonMesh mesh{MeshOptions()};
  const MeshView view = ViewOf(WallPoints(2));
  mesh.Update(view, SnapshotOf(view), SE3());
  MapSnapshot later = SnapshotOf(view);
  for (LandmarkEstimate& landmark : later.landmarks)
    landmark.p_W.z() += 0.01;
  mesh.Update(ViewOf({}, 1), later, SE3());
  ASSERT_EQ(mesh.vertices().size(), 25u);
  for (const MeshVertex& vertex : mesh.vertices())
    EXPECT_NEAR(vertex.p_W.z(), 2.01, 1e-12);
}

TEST(HorizonMesh, FacesThatTheNewTriangulationLacksAreReplaced) {
  HorizonMesh mesh{MeshOptions()};
  // A square, cut along one diagonal; with a point in the middle all old faces are wrong.
  std::vector<MeshPoint> points = {PointAt(0, {-0.3, -0.3, 2}),
                                   PointAt(1, {0.3, -0.3, 2}),
                                   PointAt(2, {0.3, 0.3, 2}),
                                   PointAt(3, {-0.3, 0.3, 2})};
  MeshView view = ViewOf(points);
  mesh.Update(view, SnapshotOf(view), SE3());
  EXPECT_EQ(mesh.faces().size(), 2u);
  points.push_back(PointAt(4, {0, 0, 2}));
  view = ViewOf(points, 1);
  mesh.Update(view, SnapshotOf(view), SE3());
  EXPECT_EQ(mesh.faces().size(), 4u);

  MeshOptions plain_union;
  plain_union.contradictions.by_triangulation = plain_union.contradictions.by_view = false;
  HorizonMesh paper(plain_union);
  view = ViewOf({points.begin(), points.end() - 1});
  paper.Update(view, SnapshotOf(view), SE3());
  view = ViewOf(points, 1);
  paper.Update(view, SnapshotOf(view), SE3());
  EXPECT_EQ(paper.faces().size(), 6u);
}

TEST(HorizonMesh, AFaceThatLandmarksAreSeenThroughGoesAfterSeveralVotes) {
  MeshOptions options;
  HorizonMesh mesh(options);
  const std::vector<MeshPoint> ghost = {
      PointAt(0, {-0.3, -0.3, 2}), PointAt(1, {0.4, -0.3, 2}), PointAt(2, {0, 0.5, 2})};
  MeshView view = ViewOf(ghost);
  mesh.Update(view, SnapshotOf(view), SE3());
  ASSERT_EQ(mesh.faces().size(), 1u);
  MeshView behind = ViewOf({PointAt(10, {0, 0, 4})});
  MapSnapshot snapshot = SnapshotOf(behind);
  const MapSnapshot both = SnapshotOf(view);
  snapshot.landmarks.insert(
      snapshot.landmarks.begin(), both.landmarks.begin(), both.landmarks.end());
  for (int vote = 1; vote <= 3; ++vote) {
    behind.frame = FrameId{vote};
    mesh.Update(behind, snapshot, SE3());
    EXPECT_EQ(mesh.faces().size(), vote < 3 ? 1u : 0u);
  }
  EXPECT_TRUE(mesh.expired().empty()) << "a face that was proven wrong is not kept for the map";
}

TEST(HorizonMesh, SupportPointsLiveAsLongAsTheirKeyframe) {
  HorizonMesh mesh(StrictHorizon());
  std::vector<MeshPoint> points = WallPoints(2);
  points[12].id.value += kFirstSupportId;
  const MeshView view = ViewOf(points, 7);
  MapSnapshot snapshot = SnapshotOf(view);
  mesh.Update(view, snapshot, SE3());
  EXPECT_EQ(mesh.faces().size(), 32u);
  snapshot.keyframes[0].T_WB.p = Vector3d(0, 0, 0.02);  // the keyframe's pose was corrected
  mesh.Update(ViewOf({}, 8), snapshot, SE3());
  EXPECT_EQ(mesh.faces().size(), 32u);
  EXPECT_NEAR(mesh.vertices().back().p_W.z(), 2.02, 1e-12);
  snapshot.keyframes[0].id = FrameId{8};
  mesh.Update(ViewOf({}, 9), snapshot, SE3());
  EXPECT_LT(mesh.faces().size(), 32u);
  ExpectInvariants(mesh, snapshot);
}

TEST(HorizonMesh, InvariantsHoldOverRandomSequences) {
  Rng rng(5);
  for (int sequence = 0; sequence < 20; ++sequence) {
    HorizonMesh mesh(StrictHorizon());
    std::vector<Vector3d> world;
    for (int i = 0; i < 300; ++i)
      world.push_back({rng.Uniform(-4, 4), rng.Uniform(-2, 2), rng.Uniform(2, 6)});
    MapSnapshot snapshot;
    for (int frame = 0; frame < 30; ++frame) {
      MeshView view = ViewOf({}, frame);
      view.T_WC = SE3(Quaterniond(Eigen::AngleAxisd(0.03 * frame, Vector3d::UnitY())),
                      Vector3d(0.05 * frame, 0, 0));
      const SE3 T_CW = view.T_WC.Inverse();
      for (int i = 0; i < 300; ++i) {
        const Vector3d p_C = T_CW * (world[i] + 0.01 * rng.Normal3());
        if (p_C.z() > 0.3 && std::abs(p_C.x() / p_C.z()) < 0.8 && rng.Uniform() < 0.7)
          view.points.push_back(PointAt(i, p_C, 0.02));
        if (rng.Uniform() < 0.05)
          view.points.push_back(PointAt(kFirstSupportId + 1000 * frame + i, p_C, 0.02));
      }
      // A horizon of 5 keyframes; landmarks leave at random.
      MapSnapshot seen = SnapshotOf(view);
      for (const LandmarkEstimate& old : snapshot.landmarks) {
        const auto same = [&](const LandmarkEstimate& l) { return l.id == old.id; };
        if (rng.Uniform() < 0.8 &&
            std::none_of(seen.landmarks.begin(), seen.landmarks.end(), same)) {
          seen.landmarks.push_back(old);
        }
      }
      std::sort(seen.landmarks.begin(), seen.landmarks.end(), [](const auto& a, const auto& b) {
        return a.id < b.id;
      });
      seen.keyframes.insert(
          seen.keyframes.begin(), snapshot.keyframes.begin(), snapshot.keyframes.end());
      if (seen.keyframes.size() > 5) seen.keyframes.erase(seen.keyframes.begin());
      snapshot = seen;
      mesh.Update(view, snapshot, SE3());
      ASSERT_NO_FATAL_FAILURE(ExpectInvariants(mesh, snapshot));
      ASSERT_NO_FATAL_FAILURE(ExpectNormalsTowards(mesh, view.T_WC.p));
    }
    EXPECT_FALSE(mesh.faces().empty());
  }
}

/// Values that real data should never contain.
double Nasty(Rng& rng) {
  const double choices[] = {0,
                            1,
                            -1,
                            1e-300,
                            1e300,
                            9.9999,
                            0.5,
                            std::numeric_limits<double>::quiet_NaN(),
                            std::numeric_limits<double>::infinity(),
                            -std::numeric_limits<double>::infinity()};
  return rng.Uniform() < 0.5 ? rng.Uniform(-1, 3) : choices[rng.Index(10)];
}

TEST(HorizonMesh, NeverThrowsOnNastyInput) {
  Rng rng(6);
  HorizonMesh mesh{MeshOptions()};
  for (int trial = 0; trial < 3000; ++trial) {
    MeshView view = ViewOf({}, trial);
    const int count = rng.Index(12);
    for (int i = 0; i < count; ++i) {
      MeshPoint point;
      point.id = LandmarkId{rng.Index(15) - 1};
      if (rng.Uniform() < 0.2) point.id.value += kFirstSupportId;
      point.bearing = Vector3d(Nasty(rng), Nasty(rng), Nasty(rng)).normalized();
      point.p_C = Vector3d(Nasty(rng), Nasty(rng), Nasty(rng));
      point.sigma_depth_m = Nasty(rng);
      view.points.push_back(point);
    }
    MapSnapshot snapshot = SnapshotOf(view);
    const auto same = [](const auto& a, const auto& b) { return a.id == b.id; };
    snapshot.landmarks.erase(
        std::unique(snapshot.landmarks.begin(), snapshot.landmarks.end(), same),
        snapshot.landmarks.end());
    mesh.Update(view, snapshot, SE3());
    for (const MeshVertex& vertex : mesh.vertices())
      ASSERT_TRUE(vertex.p_W.allFinite());
  }
}

TEST(HorizonMesh, FewPointsHaveNoFaces) {
  HorizonMesh mesh{MeshOptions()};
  std::vector<MeshPoint> points;
  for (int count = 0; count < 3; ++count) {
    const MeshView view = ViewOf(points, count);
    mesh.Update(view, SnapshotOf(view), SE3());
    EXPECT_TRUE(mesh.faces().empty());
    EXPECT_TRUE(mesh.vertices().empty());
    points.push_back(PointAt(count, {0.1 * count, 0, 2}));
  }
}

// Better depths are shown; what was matched stays what faces are judged by and the map is made of.
TEST(HorizonMesh, ShowsSupportPointsAtTheirBetterDepths) {
  HorizonMesh mesh{StrictHorizon()};
  std::vector<MeshPoint> points = WallPoints(2);
  for (MeshPoint& point : points)
    if (point.id.value % 2 == 1) point.id.value += kFirstSupportId;
  const MeshView view = ViewOf(points);
  mesh.Update(view, SnapshotOf(view), SE3());
  std::vector<Vector3d> matched;
  for (const MeshVertex& vertex : mesh.vertices())
    matched.push_back(vertex.shown_W);
  const double scale = 1.05;
  mesh.Take(
      {std::vector<int>(mesh.faces().size(), -1), std::vector<double>(matched.size(), scale), {}});
  const auto expect_shown = [&](const SE3& T_WC) {
    for (std::size_t i = 0; i < matched.size(); ++i) {
      const MeshVertex& vertex = mesh.vertices()[i];
      const double factor = IsSupport(vertex.id) ? scale : 1;
      EXPECT_NEAR((vertex.shown_W - T_WC * (factor * matched[i])).norm(), 0, 1e-9);
      EXPECT_NEAR((vertex.p_W - T_WC * matched[i]).norm(), 0, 1e-9);
    }
  };
  expect_shown(SE3());
  // The carrying keyframe moves with the next estimate, and its points with it.
  MapSnapshot next = SnapshotOf(view);
  const SE3 T_WC(Quaterniond::Identity(), {0.1, 0, 0.02});
  next.keyframes[0].T_WB = T_WC;
  for (LandmarkEstimate& landmark : next.landmarks)
    landmark.p_W = T_WC * landmark.p_W;
  mesh.Update(ViewOf({}, 1), next, SE3());
  ASSERT_EQ(mesh.vertices().size(), matched.size());
  expect_shown(T_WC);
  mesh.Clear();
  ASSERT_FALSE(mesh.expired().empty());
  double farthest = 0;
  for (const ExpiredFace& face : mesh.expired())
    farthest = std::max({farthest, face.p_W[0].z(), face.p_W[1].z(), face.p_W[2].z()});
  EXPECT_NEAR(farthest, 2 + 0.02, 1e-9);
}

}  // namespace
}  // namespace facet
