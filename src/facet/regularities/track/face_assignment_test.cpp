// SPDX-License-Identifier: BSD-2-Clause
// A board that leans on a wall crosses the wall's plane: each surface stays with its own plane.
#include "facet/regularities/track/face_assignment.h"

#include <algorithm>
#include <numbers>

#include <gtest/gtest.h>

#include "facet/geometry/so3.h"
#include "facet/testing/regularities/test_scene.h"

namespace facet {
namespace {

using testing::MakeFaces;
using testing::MakeWall;
using testing::Patch;

constexpr int kBoard = 0, kWall = 1;

Patch WithStep(Patch patch, double step_m) {
  patch.step_m = step_m;
  return patch;
}

class FaceAssignmentTest : public ::testing::Test {
 protected:
  FaceAssignmentTest() {
    map_.latest.t = Timestamp{1'000'000'000};
    const Vector3d down = ExpSO3({0, 7 * std::numbers::pi / 180, 0}) * -Vector3d::UnitZ();
    board_ = {crossing_ + 0.5 * down, -0.5 * Vector3d::UnitY(), 0.5 * down, 0.2};
    planes_ = {Known(board_, PlaneId{4}), Known(strip_, PlaneId{7})};
    Show(board_, kBoard);
  }

  TrackedPlane Known(const Patch& patch, PlaneId id) const {
    PlaneCandidate candidate;
    candidate.plane_W = patch.ToPlane();
    if (candidate.plane_W.SignedDistance(view_.camera_W) < 0)
      candidate.plane_W = {-candidate.plane_W.n, -candidate.plane_W.d};
    candidate.centroid_W = patch.centre_W;
    TrackedPlane known(candidate, map_.latest.t);
    if (id.IsValid()) known.Confirm(id, Timestamp{});
    known.estimate.plane_W = candidate.plane_W;
    known.estimate.anchor_W = candidate.centroid_W;
    known.estimate.covariance = 1e-6 * Matrix<10, 10>::Identity();
    return known;
  }
  void Show(const Patch& patch, int plane) {
    const SurfaceFaces faces = MakeFaces({patch}, view_);
    ExtendPlanes(faces, std::vector<int>(faces.faces.size(), plane), map_.latest.t, planes_);
  }
  std::vector<int> ClaimStrip() const {
    return AssignFaces(MakeFaces({strip_}, view_), planes_, map_, RegularityOptions());
  }
  LandmarkEstimate LandmarkAt(const Vector3d& p_W, PlaneId plane) const {
    LandmarkEstimate landmark;
    landmark.id = LandmarkId{static_cast<std::int64_t>(map_.landmarks.size())};
    landmark.p_W = p_W;
    landmark.planes[0] = plane;
    return landmark;
  }

  testing::TestView view_{{0, 0.5, 1.4}, 0.015, 1, 0, 3};
  MapSnapshot map_;
  const Vector3d crossing_{3, 0, 1.4};  // the wall is at x = 3; the board meets it at this height
  Patch board_;
  // Wall beside the board, where it is at most 4 cm from the board's plane.
  const Patch strip_ = WithStep(MakeWall({3, 0.85, 1.4}, 0, 0.6, 0.6), 0.15);
  std::vector<TrackedPlane> planes_;
};

TEST_F(FaceAssignmentTest, APlaneGrowsOverWhatIsWithinItsGate) {
  planes_.pop_back();
  const std::vector<int> claims = ClaimStrip();
  EXPECT_GT(std::count(claims.begin(), claims.end(), kBoard), 3);
}

TEST_F(FaceAssignmentTest, TheOtherSideIsNotClaimed) {
  planes_.pop_back();
  Plane& board_W = planes_[kBoard].estimate.plane_W;
  board_W = {-board_W.n, -board_W.d};
  const std::vector<int> claims = ClaimStrip();
  EXPECT_EQ(std::count(claims.begin(), claims.end(), kBoard), 0);
}

// The gate is widest for corners that are known to as much.
TEST_F(FaceAssignmentTest, NothingBeyondTheLargestGateIsClaimed) {
  planes_ = {Known(strip_, PlaneId{7})};
  Show(strip_, 0);
  const auto num_claimed = [&](double before_m, double sigma_m) {
    Patch patch = strip_;
    patch.centre_W.x() -= before_m;
    SurfaceFaces faces = MakeFaces({patch}, view_);
    for (FacePoint& point : faces.points) {
      point.p_W.x() = strip_.centre_W.x() - before_m;
      point.sigma_along_m = sigma_m;
    }
    const std::vector<int> claims = AssignFaces(faces, planes_, map_, RegularityOptions());
    return std::count(claims.begin(), claims.end(), 0);
  };
  EXPECT_GT(num_claimed(0.045, 0.05), 3);
  EXPECT_EQ(num_claimed(0.055, 0.05), 0);
  EXPECT_EQ(num_claimed(0.045, 0.02), 0);        // two sigmas off
  EXPECT_EQ(num_claimed(0.0, 0.3), 0);           // hardly known: on no plane
  view_.camera_W.x() -= 4 * kFarDistance_m - 3;  // the wall is at x = 3
  EXPECT_GT(num_claimed(0.19, 0.2), 3);
  EXPECT_EQ(num_claimed(0.23, 0.2), 0);
}

TEST_F(FaceAssignmentTest, FacesThatLieAcrossAreNotClaimed) {
  view_.sigma_depth_m = 0;  // normals are what they are turned to
  planes_ = {Known(strip_, PlaneId{7})};
  Show(strip_, 0);
  SurfaceFaces faces = MakeFaces({strip_}, view_);
  for (SurfaceFace& face : faces.faces)
    face.n_W = ExpSO3({0, 30 * std::numbers::pi / 180, 0}) * face.n_W;
  const std::vector<int> claims = AssignFaces(faces, planes_, map_, RegularityOptions());
  EXPECT_EQ(std::count(claims.begin(), claims.end(), 0), 0);
  const std::vector<int> as_it_is =
      AssignFaces(MakeFaces({strip_}, view_), planes_, map_, RegularityOptions());
  EXPECT_GT(std::count(as_it_is.begin(), as_it_is.end(), 0), 3);
}

// Landmarks and surface far before the crossing are no matter of dispute.
TEST_F(FaceAssignmentTest, FarFromWhereTheyCrossPlanesDisputeNothing) {
  Show(strip_, kWall);
  const Vector3d far_W = crossing_ + Vector3d(0, 0.85, -1.5);  // 18 cm from the board's plane
  const Patch below = MakeWall(far_W, 0, 0.6, 0.6);
  Show(below, kWall);
  map_.landmarks = {LandmarkAt(far_W, PlaneId{4})};
  PlaneAssignments out;
  DetachFromForeignSurface(map_, planes_, out);
  EXPECT_TRUE(out.detached.empty());
  map_.landmarks = {LandmarkAt(strip_.centre_W, PlaneId{4})};
  DetachFromForeignSurface(map_, planes_, out);
  EXPECT_EQ(out.detached.size(), 1u);
}

TEST_F(FaceAssignmentTest, ButNotOntoSurfaceThatIsKnownToBeAnothers) {
  Show(strip_, kWall);
  const std::vector<int> claims = ClaimStrip();
  EXPECT_EQ(std::count(claims.begin(), claims.end(), kBoard), 0);
  EXPECT_GT(std::count(claims.begin(), claims.end(), kWall),
            static_cast<std::ptrdiff_t>(claims.size() * 9 / 10));
}

TEST_F(FaceAssignmentTest, OfTwoPlanesThatBothKnowTheSurfaceTheNearestHasIt) {
  Show(strip_, kWall);
  planes_[kBoard].extent.Add(planes_[kWall].extent, planes_[kBoard].estimate.plane_W);
  const std::vector<int> claims = ClaimStrip();
  EXPECT_GT(std::count(claims.begin(), claims.end(), kWall),
            std::count(claims.begin(), claims.end(), kBoard));
}

TEST_F(FaceAssignmentTest, APlaneThatSleepsClaimsNothing) {
  Show(strip_, kWall);
  map_.latest.t = map_.latest.t + FromSeconds(PlaneTrackingOptions().active_s + 0.1);
  const std::vector<int> claims = ClaimStrip();
  EXPECT_EQ(std::count(claims.begin(), claims.end(), -1),
            static_cast<std::ptrdiff_t>(claims.size()));
}

TEST_F(FaceAssignmentTest, SurfaceThatWasTakenForAnothersIsGivenUp) {
  const Vector3d in_strip(3, 0.85, 1.3);
  planes_[kBoard].extent.AddTriangle(
      {in_strip - Vector3d(0, 0.2, 0.2), in_strip + Vector3d(0, 0.2, -0.2), in_strip});
  planes_[kBoard].extent.AddTriangle(
      {in_strip + Vector3d(0, 0.2, 0.2), in_strip + Vector3d(0, -0.2, 0.2), in_strip});
  const Vector3d wrong = in_strip - Vector3d(0, 0, 0.1);  // 2.5 cm from the board's plane
  ASSERT_TRUE(planes_[kBoard].extent.HasSurface(wrong));
  map_.landmarks = {LandmarkAt(wrong, PlaneId{4})};
  map_.landmarks.push_back(LandmarkAt(board_.centre_W, PlaneId{4}));
  PlaneAssignments out;
  DetachFromForeignSurface(map_, planes_, out);
  EXPECT_TRUE(out.IsEmpty());  // it is the board's as far as anybody knows

  Show(strip_, kWall);
  EXPECT_FALSE(planes_[kBoard].extent.HasSurface(wrong));
  EXPECT_TRUE(planes_[kBoard].extent.HasSurface(board_.centre_W));
  DetachFromForeignSurface(map_, planes_, out);
  ASSERT_EQ(out.detached.size(), 1u);
  EXPECT_EQ(out.detached[0], (std::pair{LandmarkId{0}, PlaneId{4}}));
}

// Along the line where they meet neither is nearer.
TEST_F(FaceAssignmentTest, SurfaceThatIsNearlyAsNearIsKept) {
  const Patch at_crossing = MakeWall({3, 0.85, 1.4}, 0, 0.2, 0.1);  // at most 6 mm from the board's
  planes_[kBoard].extent.AddTriangle({at_crossing.centre_W + Vector3d(0, -0.4, -0.4),
                                      at_crossing.centre_W + Vector3d(0, 0.4, -0.4),
                                      at_crossing.centre_W + Vector3d(0, 0, 0.5)});
  const double area_m2 = planes_[kBoard].extent.area_m2();
  view_.sigma_depth_m = 0;
  Show(at_crossing, kWall);
  EXPECT_EQ(planes_[kBoard].extent.area_m2(), area_m2);
}

TEST_F(FaceAssignmentTest, OnlyTheNewestViewBecomesSurface) {
  planes_ = {Known(strip_, PlaneId{7})};
  SurfaceFaces faces = MakeFaces({strip_}, view_);
  for (SurfaceFace& face : faces.faces)
    face.in_view = false;
  const std::vector<int> all_on_it(faces.faces.size(), 0);
  planes_[0].seen.last = Timestamp{0};
  ExtendPlanes(faces, all_on_it, map_.latest.t, planes_);
  EXPECT_EQ(planes_[0].extent.area_m2(), 0);
  EXPECT_EQ(planes_[0].seen.last, Timestamp{0});
  for (SurfaceFace& face : faces.faces)
    face.in_view = true;
  ExtendPlanes(faces, all_on_it, map_.latest.t, planes_);
  EXPECT_GT(planes_[0].extent.area_m2(), 0.2);
  EXPECT_EQ(planes_[0].seen.last, map_.latest.t);
}

// A vanished surface is no reason to leave, as long as nobody else has it.
TEST_F(FaceAssignmentTest, LandmarksWithoutSurfaceStay) {
  map_.landmarks = {LandmarkAt(crossing_ + Vector3d(0, 2, 0), PlaneId{4})};
  PlaneAssignments out;
  DetachFromForeignSurface(map_, planes_, out);
  EXPECT_TRUE(out.IsEmpty());
}

// The two sides of a board, or a cupboard before a wall.
TEST_F(FaceAssignmentTest, ParallelPlanesDisputeNothing) {
  for (const double gap_m : {0.06, 0.08, 0.1}) {
    for (const bool is_opposite : {false, true}) {
      const Patch near = MakeWall({3, 0, 1.4}, 0, 2, 2);
      const Patch far = MakeWall({3 + gap_m, 0, 1.4}, 0, 2, 2);
      planes_ = {Known(near, PlaneId{4}), Known(far, PlaneId{7})};
      Plane& far_W = planes_[1].estimate.plane_W;
      if (is_opposite) far_W = {-far_W.n, -far_W.d};
      Show(near, 0);
      const double area_m2 = planes_[0].extent.area_m2();
      Show(far, 1);
      EXPECT_EQ(planes_[0].extent.area_m2(), area_m2) << gap_m;
    }
  }
}

// A wall that is known up to 30 cm before the corner goes on to there.
TEST_F(FaceAssignmentTest, APlaneGrowsIntoACorner) {
  const Patch side = MakeWall({2.5, 1, 1.4}, 0.5 * std::numbers::pi, 1, 2);
  planes_ = {Known(MakeWall({3, 0, 1.4}, 0, 1.4, 2), PlaneId{4}), Known(side, PlaneId{7})};
  Show(MakeWall({3, 0, 1.4}, 0, 1.4, 2), 0);
  Show(side, 1);
  const std::vector<int> claims =
      AssignFaces(MakeFaces({MakeWall({3, 0.85, 1.4}, 0, 0.3, 1)}, view_), planes_, map_, {});
  EXPECT_GT(std::count(claims.begin(), claims.end(), 0),
            static_cast<std::ptrdiff_t>(claims.size() * 3 / 4));
}

// The corner of a room: both walls know the edge, and neither takes it from the other.
TEST_F(FaceAssignmentTest, PlanesAtALargeAngleDisputeNothing) {
  const Patch side = MakeWall({2.5, 0, 1.4}, 0.5 * std::numbers::pi, 1, 2);
  planes_ = {Known(side, PlaneId{4}), Known(MakeWall({3, 0.5, 1.4}, 0, 1, 2), PlaneId{7})};
  Show(side, 0);
  const double area_m2 = planes_[0].extent.area_m2();
  Show(MakeWall({3, 0.5, 1.4}, 0, 1, 2), 1);
  EXPECT_EQ(planes_[0].extent.area_m2(), area_m2);
}

}  // namespace
}  // namespace facet
