// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/detect/surface_face.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace facet {
namespace {

SearchMesh OneFace(const Vector3d& camera_W) {
  SearchMesh mesh;
  mesh.T_WC.p = camera_W;
  mesh.focal_px = 0.7 / 1.5e-3;
  mesh.baseline_m = 0.11;
  mesh.vertices = {{0, 0, 2}, {1, 0, 2}, {0, 1, 2}};
  mesh.faces = {{0, 1, 2}};
  mesh.vertex_ids = {LandmarkId{1}, LandmarkId{2}, LandmarkId{3}};
  mesh.sigma_depth_m = {0.1, 0.2, 0.3};
  mesh.may_vote = {1};
  mesh.in_view = {1};
  return mesh;
}

TEST(SurfaceFaceTest, KnowsCentreNormalAndArea) {
  SurfaceFaces faces;
  FillSurfaceFaces(OneFace(Vector3d(0, 0, 1)), faces);
  ASSERT_EQ(faces.faces.size(), 1u);
  EXPECT_LT((faces.faces[0].centre_W - Vector3d(1.0 / 3, 1.0 / 3, 2)).norm(), 1e-12);
  EXPECT_LT((faces.faces[0].n_W - Vector3d::UnitZ()).norm(), 1e-12);
  EXPECT_NEAR(faces.faces[0].area_m2, 0.5, 1e-12);
  EXPECT_TRUE(faces.faces[0].may_vote);
  EXPECT_TRUE(faces.faces[0].in_view);
  EXPECT_EQ(faces.camera.p_W, Vector3d(0, 0, 1));
  FillSurfaceFaces(SearchMesh(), faces);
  EXPECT_TRUE(faces.faces.empty() && faces.points.empty());
}

// Half a square metre whose middle is seen from here.
double SearchAreaSeenFrom(double distance_m) {
  const SearchMesh mesh = OneFace(Vector3d(1.0 / 3, 1.0 / 3, 2 - distance_m));
  SurfaceFaces faces;
  FillSurfaceFaces(mesh, faces);
  return faces.faces[0].search_area_m2;
}

TEST(SurfaceFaceTest, NearSurfacesCountByTheirPartOfTheView) {
  EXPECT_EQ(SearchAreaSeenFrom(kFarDistance_m), 0.5);
  EXPECT_EQ(SearchAreaSeenFrom(kFullSizeDistance_m), 0.5);
  EXPECT_NEAR(SearchAreaSeenFrom(kFullSizeDistance_m / 2), 2, 1e-12);
  EXPECT_NEAR(SearchAreaSeenFrom(kFullSizeDistance_m / 3), 4.5, 1e-12);
  EXPECT_TRUE(std::isfinite(SearchAreaSeenFrom(0)));
}

TEST(SurfaceFaceTest, FarSurfacesCountByTheirPartOfTheView) {
  EXPECT_NEAR(SearchAreaSeenFrom(2 * kFarDistance_m), 0.5 / 4, 1e-12);
  SurfaceFaces faces;
  FillSurfaceFaces(OneFace(Vector3d(1.0 / 3, 1.0 / 3, 2 - 3 * kFarDistance_m)), faces);
  EXPECT_NEAR(faces.faces[0].length_scale, 3, 1e-12);
  EXPECT_NEAR(faces.points[0].Flatness_m(), 3 * kSurfaceFlatness_m, 1e-3);
  FillSurfaceFaces(OneFace(Vector3d(1.0 / 3, 1.0 / 3, 2 - 0.9 * kFarDistance_m)), faces);
  EXPECT_EQ(faces.faces[0].length_scale, 1);
  EXPECT_EQ(faces.points[0].Flatness_m(), kSurfaceFlatness_m);
}

TEST(SurfaceFaceTest, SigmaIsThatOfTheDepthAlongTheRayAndSmallAcross) {
  SurfaceFaces faces;
  FillSurfaceFaces(OneFace(Vector3d(0, 0, 0)), faces);
  EXPECT_NEAR(faces.points[0].SigmaAlong(Vector3d::UnitZ()), 0.1, 1e-12);
  EXPECT_NEAR(faces.points[0].SigmaAlong(Vector3d::UnitX()), 2 * 1.5e-3, 1e-12);
  const Vector3d between = Vector3d(1, 0, 1).normalized();
  EXPECT_NEAR(faces.points[0].SigmaAlong(between), std::sqrt((0.01 + 9e-6) / 2), 1e-12);
}

TEST(SurfaceFaceTest, FacesWithoutAFiniteAreaAreNoSurface) {
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(), 1e200}) {
    SearchMesh mesh = OneFace(Vector3d::Zero());
    mesh.vertices[1].x() = bad;
    SurfaceFaces faces;
    FillSurfaceFaces(mesh, faces);
    EXPECT_FALSE(faces.faces[0].may_vote);
    EXPECT_EQ(faces.faces[0].area_m2, 0);
  }
  SearchMesh mesh = OneFace(Vector3d::Zero());
  mesh.vertices[1] = mesh.vertices[0];
  SurfaceFaces faces;
  FillSurfaceFaces(mesh, faces);
  EXPECT_FALSE(faces.faces[0].may_vote);
}

TEST(SurfaceFaceTest, ACameraInAVertexIsNoProblem) {
  SurfaceFaces faces;
  FillSurfaceFaces(OneFace(Vector3d(0, 0, 2)), faces);
  EXPECT_TRUE(std::isfinite(faces.points[0].SigmaAlong(Vector3d::UnitX())));
}

}  // namespace
}  // namespace facet
