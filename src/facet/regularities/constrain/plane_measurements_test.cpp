// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/constrain/plane_measurements.h"

#include <gtest/gtest.h>

#include "facet/geometry/so3.h"
#include "facet/regularities/detect/common_error.h"
#include "facet/testing/regularities/test_scene.h"

namespace facet {
namespace {

using testing::MakeMesh;
using testing::MakeWall;
using testing::Patch;

constexpr double kWithoutCommonError_m = 1e9;  // baseline

class PlaneMeasurementsTest : public ::testing::Test {
 protected:
  PlaneMeasurementsTest() {
    map_.keyframes.push_back({FrameId{77}, Timestamp{0}, T_WB_});
    map_.latest.T_WB = T_WB_;
    view_.camera_W = T_WB_.p;
  }

  // A plane whose surface is known there, and which was seen now.
  TrackedPlane Known(const Patch& patch, PlaneId id) const {
    PlaneCandidate candidate;
    candidate.plane_W = patch.ToPlane();
    candidate.centroid_W = patch.centre_W;
    TrackedPlane known(candidate, Timestamp{0});
    known.estimate.plane_W = candidate.plane_W;
    if (id.IsValid()) known.Confirm(id, Timestamp{});
    const Vector3d &c = patch.centre_W, &a = patch.half_a_W, &b = patch.half_b_W;
    known.extent.AddTriangle({c - a - b, c + a - b, c + a + b});
    known.extent.AddTriangle({c - a - b, c + a + b, c - a + b});
    return known;
  }

  // No face is on a plane yet; all points are support points that were matched just now.
  std::vector<PlaneMeasurement> Measure(const std::vector<Patch>& patches,
                                        const TrackedPlane& plane) {
    SearchMesh mesh = MakeMesh(patches, view_);
    mesh.first_match = LandmarkId{first_match_};
    mesh.end_match = LandmarkId{1'000'000};
    FillSurfaceFaces(mesh, faces_);
    plane_index_of_face_.resize(faces_.faces.size(), -1);
    return MeasurePlanes(mesh, faces_, plane_index_of_face_, {plane}, map_, options_);
  }

  const SE3 T_WB_{ExpSO3({0.2, -0.1, 0.4}), Vector3d(0.5, 0.2, 1.3)};
  testing::TestView view_{{}, 0.01, 1, 0, 1};
  MapSnapshot map_;
  PlaneMeasurementOptions options_;
  SurfaceFaces faces_;
  std::vector<int> plane_index_of_face_;
  std::int64_t first_match_ = 0;
  const Patch wall_ = MakeWall({3, 0, 1.4}, 0.1, 3, 2);
};

TEST_F(PlaneMeasurementsTest, SaysWhereTheBodySawThePlane) {
  view_.sigma_depth_m = 1e-4;
  view_.pixel_noise = 0;
  const std::vector<PlaneMeasurement> found = Measure({wall_}, Known(wall_, PlaneId{6}));
  ASSERT_EQ(found.size(), 1u);
  const PlaneMeasurement& measurement = found[0];
  EXPECT_EQ(measurement.plane, PlaneId{6});
  EXPECT_EQ(measurement.frame, FrameId{77});
  const Plane plane = wall_.ToPlane();
  EXPECT_NEAR(plane.SignedDistance(T_WB_ * measurement.centre_B), 0, 1e-3);
  for (const Vector3d& along_B : measurement.along_B) {
    EXPECT_NEAR(along_B.norm(), 1, 1e-12);
    EXPECT_NEAR(plane.n.dot(T_WB_.q * along_B), 0, 1e-3);
  }
  EXPECT_NEAR(measurement.along_B[0].dot(measurement.along_B[1]), 0, 1e-12);
}

// The points' noise is what the mesh says it is, so the whitened errors have unit variance.
TEST_F(PlaneMeasurementsTest, ErrorsAreAsLargeAsTheSigmasSay) {
  options_.sigma_scale = 1;
  options_.common_share = 0;
  view_.baseline_m = kWithoutCommonError_m;
  view_.sigma_depth_m = 0.02;
  const Plane plane = wall_.ToPlane();
  constexpr int kRuns = 400;
  Vector3d squares = Vector3d::Zero();
  for (int run = 0; run < kRuns; ++run) {
    ++view_.seed;
    const std::vector<PlaneMeasurement> found = Measure({wall_}, Known(wall_, PlaneId{0}));
    ASSERT_EQ(found.size(), 1u);
    const PlaneMeasurement& s = found[0];
    const Vector3d error(plane.SignedDistance(T_WB_ * s.centre_B) / s.sigma_m,
                         plane.n.dot(T_WB_.q * s.along_B[0]) / s.sigma_rad[0],
                         plane.n.dot(T_WB_.q * s.along_B[1]) / s.sigma_rad[1]);
    squares += error.cwiseAbs2() / kRuns;
  }
  // The flatness of real surfaces (5 mm) is in the sigmas, but not in this wall.
  for (int k = 0; k < 3; ++k)
    EXPECT_NEAR(squares(k), 1, 0.25) << k;
}

TEST_F(PlaneMeasurementsTest, ScaleAndWhatAllDisparitiesAreOffWidenTheSigmas) {
  const TrackedPlane known = Known(wall_, PlaneId{0});
  options_.sigma_scale = 1;
  options_.common_share = 0;
  view_.baseline_m = kWithoutCommonError_m;
  const PlaneMeasurement narrow = Measure({wall_}, known).at(0);
  options_.sigma_scale = 3;
  view_.baseline_m = 0.11;
  const PlaneMeasurement wide = Measure({wall_}, known).at(0);
  const Vector3d centre_W = T_WB_ * wide.centre_B;
  const CommonError common = CommonErrorOf(
      wall_.ToPlane(), centre_W, {view_.camera_W, 0, kCommonDisparity_px / (467 * 0.11)});
  EXPECT_GT(common.offset_m, 1e-3);
  EXPECT_NEAR(wide.sigma_m, std::hypot(3 * narrow.sigma_m, common.offset_m), 1e-5);
  for (std::size_t k = 0; k < 2; ++k)
    EXPECT_NEAR(wide.sigma_rad[k], std::hypot(3 * narrow.sigma_rad[k], common.slope_rad), 1e-5);
}

// However many points there are: what they have in common, a share of one point's sigma, stays.
TEST_F(PlaneMeasurementsTest, WhatPointsHaveInCommonDoesNotAverageOut) {
  const TrackedPlane known = Known(wall_, PlaneId{0});
  view_.baseline_m = kWithoutCommonError_m;
  options_.sigma_scale = 1e-9;
  view_.sigma_depth_m = 0.02;
  options_.common_share = 0.5;
  const PlaneMeasurement half = Measure({wall_}, known).at(0);
  options_.common_share = 1;
  const PlaneMeasurement one = Measure({wall_}, known).at(0);
  EXPECT_NEAR(one.sigma_m, 2 * half.sigma_m, 1e-9);
  EXPECT_NEAR(one.sigma_rad[1], 2 * half.sigma_rad[1], 1e-9);
  // Depth sigma seen along the wall's normal, and the flatness of real surfaces.
  EXPECT_GT(one.sigma_m, 0.01);
  EXPECT_LT(one.sigma_m, 0.022);
}

// Where the plane is thought to be must not draw what is measured: the mean over many keyframes is
// where the wall is, although a third of the points are farther from the plane than a sigma.
TEST_F(PlaneMeasurementsTest, ADisplacedPlaneDoesNotConfirmItself) {
  view_.sigma_depth_m = 0.03;
  TrackedPlane displaced = Known(wall_, PlaneId{0});
  displaced.estimate.plane_W.d += 0.02;
  const Plane plane = wall_.ToPlane();
  constexpr int kRuns = 200;
  double mean_m = 0, sigma_m = 0;
  for (int run = 0; run < kRuns; ++run) {
    ++view_.seed;
    const std::vector<PlaneMeasurement> found = Measure({wall_}, displaced);
    ASSERT_EQ(found.size(), 1u);
    mean_m += plane.SignedDistance(T_WB_ * found[0].centre_B) / kRuns;
    sigma_m += found[0].sigma_m / kRuns;
  }
  EXPECT_LT(std::abs(mean_m), 0.0015);
  EXPECT_LT(std::abs(mean_m), 0.25 * sigma_m);
}

TEST_F(PlaneMeasurementsTest, LandmarksDoNotCount) {
  const TrackedPlane known = Known(wall_, PlaneId{0});
  first_match_ = 1000;  // no point of the wall
  EXPECT_TRUE(Measure({wall_}, known).empty());
  first_match_ = 0;
  EXPECT_EQ(Measure({wall_}, known).size(), 1u);
}

TEST_F(PlaneMeasurementsTest, NeitherDoPointsOfOtherPlanes) {
  const TrackedPlane known = Known(wall_, PlaneId{0});
  ASSERT_EQ(Measure({wall_}, known).size(), 1u);
  std::fill(plane_index_of_face_.begin(), plane_index_of_face_.end(), 1);
  EXPECT_TRUE(Measure({wall_}, known).empty());
  // Points between faces of both count.
  std::fill_n(plane_index_of_face_.begin(), plane_index_of_face_.size() / 2, 0);
  EXPECT_EQ(Measure({wall_}, known).size(), 1u);
}

TEST_F(PlaneMeasurementsTest, OnlyWhereTheSurfaceIsKnown) {
  TrackedPlane known = Known(wall_, PlaneId{0});
  Patch beside = wall_;
  beside.centre_W += 4 * wall_.half_a_W;
  EXPECT_TRUE(Measure({beside}, known).empty());
}

TEST_F(PlaneMeasurementsTest, APlaneThatIsNotSeenNowIsNotMeasured) {
  TrackedPlane known = Known(wall_, PlaneId{0});
  view_.time_s = 0.2;
  EXPECT_TRUE(Measure({wall_}, known).empty());
}

TEST_F(PlaneMeasurementsTest, PointsThatAreHardlyKnownDoNotCount) {
  view_.sigma_depth_m = 0.1;
  EXPECT_TRUE(Measure({wall_}, Known(wall_, PlaneId{0})).empty());
}

TEST_F(PlaneMeasurementsTest, TwoSurfacesAreNoPlane) {
  Patch behind = wall_;
  behind.centre_W.x() += 0.08;
  view_.sigma_depth_m = 0.03;  // both are within the gates
  TrackedPlane between = Known(wall_, PlaneId{0});
  between.estimate.plane_W.d += 0.04;
  ASSERT_EQ(Measure({wall_}, between).size(), 1u);
  EXPECT_TRUE(Measure({wall_, behind}, between).empty());
}

TEST_F(PlaneMeasurementsTest, ANarrowStripSaysNothing) {
  Patch strip = MakeWall({3, 0, 1.4}, 0.1, 3, 0.02);
  strip.step_m = 0.02;
  EXPECT_TRUE(Measure({strip}, Known(strip, PlaneId{0})).empty());
}

TEST_F(PlaneMeasurementsTest, NeitherDoPlanesThatTheEstimatorDoesNotKnow) {
  EXPECT_TRUE(Measure({wall_}, Known(wall_, PlaneId{})).empty());
  map_.keyframes.clear();
  EXPECT_TRUE(Measure({wall_}, Known(wall_, PlaneId{0})).empty());
}

}  // namespace
}  // namespace facet
