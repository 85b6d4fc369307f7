// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/detect/plane_candidate.h"

#include <cmath>

#include <gtest/gtest.h>

#include "facet/geometry/angles.h"
#include "facet/geometry/so3.h"
#include "facet/testing/regularities/test_scene.h"

namespace facet {
namespace {

using testing::AllOf;
using testing::MakeFaces;
using testing::MakeFloor;
using testing::MakeWall;
using testing::Patch;
using testing::TestView;
using testing::Turned;

std::vector<PlaneCandidate> Fit(const SurfaceFaces& faces, const Plane& start) {
  const DetectionOptions options;
  return FitCandidates(
      faces, FacesAround(faces, AllOf(faces), start), start, options.min_area_m2, options);
}

TEST(PlaneCandidateTest, FitsAllThreeDegreesOfFreedomFromARoughStart) {
  TestView view;
  view.camera_W = {0, 0, 1};
  const Patch wall = Turned(MakeWall({3, 0.5, 1.2}, 0.3, 3, 2), Vector3d(1, 2, 3), 2 * kDegree);
  const SurfaceFaces faces = MakeFaces({wall}, view);
  Plane start{Vector3d(std::cos(0.3), std::sin(0.3), 0), 0};
  start.d = start.n.dot(wall.centre_W) + 0.015;
  const auto found = Fit(faces, start);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_GT(std::abs(found[0].plane_W.n.dot(wall.ToPlane().n)), std::cos(0.5 * kDegree));
  EXPECT_NEAR(wall.ToPlane().SignedDistance(found[0].centroid_W), 0, 0.005);
  EXPECT_NEAR(found[0].area_m2, 6, 0.6);
  EXPECT_GT(found[0].plane_W.SignedDistance(view.camera_W), 0);
  EXPECT_NEAR(found[0].plane_W.n.norm(), 1, 1e-12);
}

// Disparities that are off all over the image, and more and more towards its sides. The camera
// looks along x.
void DisturbDisparities(Rng& rng, SurfaceFaces& faces) {
  const Vector3d error = faces.camera.sigma_inverse_depth * rng.Normal3();
  for (FacePoint& point : faces.points) {
    const Vector3d p_C = point.p_W - faces.camera.p_W;
    const double inverse_depth = 1 / p_C.x() + error.dot(p_C) / p_C.x();
    point.p_W = faces.camera.p_W + p_C / (p_C.x() * inverse_depth);
  }
}

TEST(PlaneCandidateTest, CovarianceAgreesWithMonteCarlo) {
  Rng rng(1);
  const Plane truth{-Vector3d::UnitX(), -3};
  double normal_nees = 0, offset_nees = 0;
  constexpr int kRuns = 600;
  for (int run = 0; run < kRuns; ++run) {
    TestView view;
    view.camera_W = {0, 0, 1};
    view.sigma_depth_m = 0.02;
    view.seed = rng.Next();
    SurfaceFaces faces = MakeFaces({MakeWall({3, 0, 1}, 0, 2.4, 1.6)}, view);
    DisturbDisparities(rng, faces);
    for (FacePoint& point : faces.points)
      point.p_W.x() += 0.005 * rng.Normal();
    const auto found = Fit(faces, truth);
    ASSERT_EQ(found.size(), 1u);
    const PlaneCandidate& candidate = found[0];
    const Matrix<3, 2> B = TangentBasis(truth.n);
    const Vector2d r = B.transpose() * (candidate.plane_W.n - truth.n);
    const Matrix2d covariance = B.transpose() * candidate.normal_covariance * B;
    normal_nees += r.dot(covariance.inverse() * r) / (2 * kRuns);
    const double offset = truth.SignedDistance(candidate.centroid_W);
    offset_nees += offset * offset / candidate.offset_variance_m2 / kRuns;
  }
  EXPECT_NEAR(normal_nees, 1, 0.2);
  EXPECT_NEAR(offset_nees, 1, 0.2);
}

TEST(PlaneCandidateTest, TwoTablesOfOneHeightAreTwoPlanes) {
  TestView view;
  view.camera_W = {0, 0, 1.5};
  const SurfaceFaces faces =
      MakeFaces({MakeFloor({2, -1.5, 0.7}, 1, 1), MakeFloor({2, 1.5, 0.7}, 1.5, 1)}, view);
  const auto found = Fit(faces, {Vector3d::UnitZ(), 0.7});
  ASSERT_EQ(found.size(), 2u);
  EXPECT_GT(std::abs(found[0].centroid_W.y() - found[1].centroid_W.y()), 2.5);
}

// A world that is larger by a factor, seen from as far by it and with as many pixels of error.
SurfaceFaces TwoTablesAndAStep(double size) {
  TestView view;
  view.camera_W = {0, 0, size * 1.5};
  view.sigma_depth_m = size * 0.02;
  view.baseline_m *= size;
  std::vector<Patch> patches = {MakeFloor({4.5, -2.5, 0.7}, 1.4, 1.6),
                                MakeFloor({4.5, 0, 0.7}, 1.4, 1.6),
                                MakeFloor({4.5, 1.8, 0.78}, 1.4, 2)};
  for (Patch& patch : patches) {
    patch.centre_W *= size;
    patch.half_a_W *= size;
    patch.half_b_W *= size;
    patch.step_m *= size;
  }
  return MakeFaces(patches, view);
}

TEST(PlaneCandidateTest, FarAwayALargerWorldHasTheSamePlanes) {
  const std::vector<PlaneCandidate> small = Fit(TwoTablesAndAStep(1), {Vector3d::UnitZ(), 0.7});
  ASSERT_GE(small.size(), 2u);
  for (const double size : {2.0, 7.0}) {
    const auto large = Fit(TwoTablesAndAStep(size), {Vector3d::UnitZ(), size * 0.7});
    ASSERT_EQ(large.size(), small.size());
    for (std::size_t k = 0; k < small.size(); ++k) {
      EXPECT_EQ(large[k].faces, small[k].faces);
      EXPECT_LT(AngleBetween(large[k].plane_W.n, small[k].plane_W.n), 1e-6);
      EXPECT_NEAR(large[k].plane_W.d / size, small[k].plane_W.d, 1e-9);
      EXPECT_NEAR(large[k].length_scale / size, small[k].length_scale, 1e-9);
      EXPECT_NEAR(large[k].offset_variance_m2 / (size * size), small[k].offset_variance_m2, 1e-12);
      EXPECT_LT((large[k].normal_covariance - small[k].normal_covariance).norm(), 1e-12);
    }
  }
}

TEST(PlaneCandidateTest, TooSmallTooFewTooNarrowTooThickIsNone) {
  TestView view;
  view.camera_W = {0, 0, 1};
  const Plane truth{Vector3d::UnitX(), 3};
  EXPECT_TRUE(Fit(MakeFaces({MakeWall({3, 0, 1}, 0, 0.3, 0.3)}, view), truth).empty());
  Patch coarse = MakeWall({3, 0, 1}, 0, 2, 1);
  coarse.step_m = 1;
  EXPECT_TRUE(Fit(MakeFaces({coarse}, view), truth).empty());  // six vertices
  Patch narrow = MakeWall({3, 0, 1}, 0, 4, 0.15);
  narrow.step_m = 0.1;
  EXPECT_TRUE(Fit(MakeFaces({narrow}, view), truth).empty());
  // Rougher than the surface of a plane and than what the points claim.
  SurfaceFaces rough = MakeFaces({MakeWall({3, 0, 1}, 0, 3, 2)}, view);
  Rng rng(2);
  for (FacePoint& point : rough.points) {
    point.sigma_along_m = 0.015;
    point.p_W.x() = 3 + (rng.Uniform() < 0.5 ? -0.035 : 0.035);
  }
  EXPECT_TRUE(Fit(rough, truth).empty());
}

TEST(PlaneCandidateTest, OrientationFollowsTheFitAndItsUncertainty) {
  const Matrix3d known = 1e-8 * Matrix3d::Identity();
  const Matrix3d vague = std::pow(5 * kDegree, 2) * Matrix3d::Identity();
  const auto leaning = [](double degree) {
    return Vector3d(std::cos(degree * kDegree), 0, std::sin(degree * kDegree));
  };
  EXPECT_EQ(OrientationOf(leaning(0), known, 2), PlaneOrientation::kVertical);
  EXPECT_EQ(OrientationOf(leaning(1.9), known, 2), PlaneOrientation::kVertical);
  EXPECT_EQ(OrientationOf(leaning(2.1), known, 2), PlaneOrientation::kOblique);
  EXPECT_EQ(OrientationOf(leaning(-9), known, 2), PlaneOrientation::kOblique);
  EXPECT_EQ(OrientationOf(leaning(9), vague, 2), PlaneOrientation::kVertical);
  EXPECT_EQ(OrientationOf(leaning(87), known, 2), PlaneOrientation::kOblique);
  EXPECT_EQ(OrientationOf(leaning(89), known, 2), PlaneOrientation::kHorizontal);
  EXPECT_EQ(OrientationOf(-leaning(89), known, 2), PlaneOrientation::kHorizontal);
  EXPECT_EQ(OrientationOf(Vector3d::UnitZ(), known, 2), PlaneOrientation::kHorizontal);
}

TEST(PlaneCandidateTest, FacesOnPlaneAreThoseWithAllCornersNearAndTheRightNormal) {
  TestView view;
  view.camera_W = {0, 0, 1};
  view.sigma_depth_m = 0.002;
  const SurfaceFaces faces = MakeFaces({MakeWall({3, 0, 1}, 0, 2, 1),
                                        MakeWall({3.2, 0, 1}, 0, 2, 1),
                                        MakeFloor({3, 0, 0.5}, 0.05, 2)},
                                       view);
  const auto on_plane = FacesOnPlane(faces, AllOf(faces), {Vector3d::UnitX(), 3}, 0.08);
  EXPECT_EQ(on_plane.size(), 2u * 8 * 4);
  for (const int f : on_plane)
    EXPECT_NEAR(faces.faces[f].centre_W.x(), 3, 0.02);
}

}  // namespace
}  // namespace facet
