// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/constrain/support_depths.h"

#include <gtest/gtest.h>

#include "facet/mesh/mesh_view.h"

namespace facet {
namespace {

constexpr double kWall_m = 4;        // from the camera at the origin, along x
constexpr double kSigmaDepth = 0.1;  // of the points

/// Three points of which the first is `offset_m` before a wall that is known.
class SupportDepthsTest : public ::testing::Test {
 protected:
  SupportDepthsTest() {
    PlaneCandidate candidate;
    candidate.plane_W = {-Vector3d::UnitX(), -kWall_m};
    candidate.centroid_W = {kWall_m, 0, 0};
    planes_.emplace_back(candidate, Timestamp{});
    TrackedPlane& wall = planes_.back();
    wall.Confirm(PlaneId{3}, Timestamp{});
    wall.estimate.plane_W = candidate.plane_W;
    wall.estimate.anchor_W = candidate.centroid_W;
    SetSigma(1e-6);
    wall.extent.AddTriangle({Vector3d(kWall_m, -1, -1), {kWall_m, 1, -1}, {kWall_m, 0, 1}});
  }
  void SetSigma(double sigma_m) { planes_[0].estimate.covariance(9, 9) = sigma_m * sigma_m; }

  double ScaleOf(double offset_m, double y = 0, bool is_support = true, bool in_view = true) const {
    const Vector3d first = (1 - offset_m / kWall_m) * Vector3d(kWall_m, y, 0);
    SearchMesh mesh;
    mesh.focal_px = 467;
    mesh.baseline_m = 0.11;
    mesh.vertices = {first, {kWall_m, 0.3, 0}, {kWall_m, 0, 0.3}};
    mesh.faces = {{0, 1, 2}};
    const std::int64_t id = is_support ? kFirstSupportId : 0;
    mesh.vertex_ids = {LandmarkId{id}, LandmarkId{id + 1}, LandmarkId{id + 2}};
    mesh.sigma_depth_m.assign(3, kSigmaDepth);
    mesh.may_vote = {1};
    mesh.in_view = {static_cast<char>(in_view ? 1 : 0)};
    SurfaceFaces faces;
    FillSurfaceFaces(mesh, faces);
    return SupportDepthScales(mesh, faces, planes_, SE3())[0];
  }

  std::vector<TrackedPlane> planes_;
};

TEST_F(SupportDepthsTest, DepthAndPlaneAreWeightedByTheirUncertainty) {
  const double offset_m = 0.1, distance_m = kWall_m - offset_m;
  const double flat_variance = 0.005 * 0.005;
  const double own = kSigmaDepth * kSigmaDepth;
  EXPECT_NEAR(ScaleOf(offset_m), 1 + own / (own + flat_variance) * offset_m / distance_m, 1e-6);
  // A plane that is known as badly as the point draws it half way.
  SetSigma(std::sqrt(own - flat_variance));
  EXPECT_NEAR(ScaleOf(offset_m), 1 + 0.5 * offset_m / distance_m, 1e-6);
}

TEST_F(SupportDepthsTest, WhatContradictsThePlaneStays) {
  EXPECT_GT(ScaleOf(2.9 * kSigmaDepth), 1);
  EXPECT_EQ(ScaleOf(3.1 * kSigmaDepth), 1);
  EXPECT_LT(ScaleOf(-2.9 * kSigmaDepth), 1);
  EXPECT_EQ(ScaleOf(-3.1 * kSigmaDepth), 1);
}

TEST_F(SupportDepthsTest, OnlyWhereSurfaceOfThePlaneIsKnown) {
  EXPECT_GT(ScaleOf(0.1, 0.4), 1);
  EXPECT_EQ(ScaleOf(0.1, 1.5), 1);
  planes_[0].state = PlaneState::kTentative;
  EXPECT_EQ(ScaleOf(0.1), 1) << "a tentative plane";
}

TEST_F(SupportDepthsTest, TheBackOfAPlaneIsAnotherSurface) {
  EXPECT_GT(ScaleOf(0.1), 1);
  Plane& front = planes_[0].estimate.plane_W;
  front = {-front.n, -front.d};
  EXPECT_EQ(ScaleOf(0.1), 1);
}

TEST_F(SupportDepthsTest, LandmarksAndWhatIsOutOfViewStay) {
  EXPECT_EQ(ScaleOf(0.1, 0, false), 1);
  EXPECT_EQ(ScaleOf(0.1, 0, true, false), 1);
}

}  // namespace
}  // namespace facet
