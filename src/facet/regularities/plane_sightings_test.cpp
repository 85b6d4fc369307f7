// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/plane_sightings.h"

#include <gtest/gtest.h>

#include "facet/regularities/test_scene.h"

namespace facet {
namespace {

using testing::MakeFaces;
using testing::MakeWall;
using testing::Patch;

class PlaneSightingsTest : public ::testing::Test {
 protected:
  PlaneSightingsTest() {
    map_.keyframes.push_back({FrameId{77}, Timestamp{5}, T_WB_});
    map_.latest.T_WB = T_WB_;
    view_.camera_W = T_WB_.p;
  }

  KnownPlane Known(const Patch& patch, PlaneId id) const {
    PlaneCandidate candidate;
    candidate.plane_W = patch.ToPlane();
    candidate.centroid_W = patch.centre_W;
    KnownPlane known(candidate, Timestamp{5});
    known.estimate.plane_W = candidate.plane_W;
    known.id = id;
    return known;
  }

  // All faces are on the first plane, and no point is a landmark.
  std::vector<PlaneSighting> Sight(const std::vector<Patch>& patches, const KnownPlane& plane) {
    faces_ = MakeFaces(patches, view_);
    const std::vector<int> plane_of_face(faces_.faces.size(), 0);
    landmark_of_point_.resize(faces_.points.size(), -1);
    return SightPlanes(
        faces_, plane_of_face, landmark_of_point_, std::span(&plane, 1), map_, options_);
  }

  const SE3 T_WB_{ExpSO3({0.2, -0.1, 0.4}), Vector3d(0.5, 0.2, 1.3)};
  testing::TestView view_{{}, 0.01, 1, 0, 1};
  MapSnapshot map_;
  SightingOptions options_;
  SurfaceFaces faces_;
  std::vector<int> landmark_of_point_;
  const Patch wall_ = MakeWall({3, 0, 1.4}, 0.1, 3, 2);
};

TEST_F(PlaneSightingsTest, SaysWhereTheBodySawThePlane) {
  view_.sigma_depth_m = 1e-4;
  view_.pixel_noise = 0;
  const std::vector<PlaneSighting> found = Sight({wall_}, Known(wall_, PlaneId{6}));
  ASSERT_EQ(found.size(), 1u);
  const PlaneSighting& sighting = found[0];
  EXPECT_EQ(sighting.plane, PlaneId{6});
  EXPECT_EQ(sighting.frame, FrameId{77});
  const Plane plane = wall_.ToPlane();
  EXPECT_NEAR(plane.SignedDistance(T_WB_ * sighting.centre_B), 0, 1e-3);
  for (const Vector3d& along_B : sighting.along_B) {
    EXPECT_NEAR(along_B.norm(), 1, 1e-12);
    EXPECT_NEAR(plane.n.dot(T_WB_.q * along_B), 0, 1e-3);
  }
  EXPECT_NEAR(sighting.along_B[0].dot(sighting.along_B[1]), 0, 1e-12);
}

// The points' noise is what the mesh says it is, so the whitened errors have unit variance.
TEST_F(PlaneSightingsTest, ErrorsAreAsLargeAsTheSigmasSay) {
  options_.sigma_scale = 1;
  options_.min_sigma_m = options_.min_sigma_deg = 0;
  view_.sigma_depth_m = 0.02;
  const Plane plane = wall_.ToPlane();
  constexpr int kRuns = 400;
  Vector3d squares = Vector3d::Zero();
  for (int run = 0; run < kRuns; ++run) {
    ++view_.seed;
    const std::vector<PlaneSighting> found = Sight({wall_}, Known(wall_, PlaneId{0}));
    ASSERT_EQ(found.size(), 1u);
    const PlaneSighting& s = found[0];
    const Vector3d error(plane.SignedDistance(T_WB_ * s.centre_B) / s.sigma_m,
                         plane.n.dot(T_WB_.q * s.along_B[0]) / s.sigma_rad[0],
                         plane.n.dot(T_WB_.q * s.along_B[1]) / s.sigma_rad[1]);
    squares += error.cwiseAbs2() / kRuns;
  }
  // The flatness of real surfaces (5 mm) is in the sigmas, but not in this wall.
  for (int k = 0; k < 3; ++k)
    EXPECT_NEAR(squares(k), 1, 0.25) << k;
}

TEST_F(PlaneSightingsTest, ScaleAndFloorsWidenTheSigmas) {
  const KnownPlane known = Known(wall_, PlaneId{0});
  options_.sigma_scale = 1;
  options_.min_sigma_m = options_.min_sigma_deg = 0;
  const PlaneSighting narrow = Sight({wall_}, known).at(0);
  options_.sigma_scale = 3;
  options_.min_sigma_m = 0.02;
  const PlaneSighting wide = Sight({wall_}, known).at(0);
  EXPECT_NEAR(wide.sigma_m, std::hypot(3 * narrow.sigma_m, 0.02), 1e-12);
  EXPECT_NEAR(wide.sigma_rad[0], 3 * narrow.sigma_rad[0], 1e-12);
}

TEST_F(PlaneSightingsTest, LandmarksDoNotCount) {
  const KnownPlane known = Known(wall_, PlaneId{0});
  faces_ = MakeFaces({wall_}, view_);
  landmark_of_point_.assign(faces_.points.size(), 3);
  EXPECT_TRUE(Sight({wall_}, known).empty());
  std::fill_n(landmark_of_point_.begin(), options_.min_points - 1, -1);
  EXPECT_TRUE(Sight({wall_}, known).empty());
  std::fill(landmark_of_point_.begin(), landmark_of_point_.end(), -1);
  EXPECT_EQ(Sight({wall_}, known).size(), 1u);
}

TEST_F(PlaneSightingsTest, PointsThatAreHardlyKnownDoNotCount) {
  view_.sigma_depth_m = 2 * options_.max_point_sigma_m;
  EXPECT_TRUE(Sight({wall_}, Known(wall_, PlaneId{0})).empty());
}

TEST_F(PlaneSightingsTest, TwoSurfacesAreNoPlane) {
  Patch step = MakeWall({3.2, 3, 1.4}, 0.1, 2, 2);
  EXPECT_TRUE(Sight({wall_, step}, Known(wall_, PlaneId{0})).empty());
}

TEST_F(PlaneSightingsTest, ANarrowStripSaysNothing) {
  Patch strip = MakeWall({3, 0, 1.4}, 0.1, 3, 0.02);
  strip.step_m = 0.02;
  EXPECT_TRUE(Sight({strip}, Known(strip, PlaneId{0})).empty());
}

TEST_F(PlaneSightingsTest, NeitherDoPlanesThatTheEstimatorDoesNotKnow) {
  EXPECT_TRUE(Sight({wall_}, Known(wall_, PlaneId{})).empty());
  map_.keyframes.clear();
  EXPECT_TRUE(Sight({wall_}, Known(wall_, PlaneId{0})).empty());
}

}  // namespace
}  // namespace facet
