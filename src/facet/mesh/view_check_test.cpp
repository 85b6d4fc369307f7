// SPDX-License-Identifier: BSD-2-Clause
#include "facet/mesh/view_check.h"

#include <array>
#include <limits>

#include <gtest/gtest.h>

#include "facet/geometry/angles.h"
#include "facet/geometry/so3.h"

namespace facet {
namespace {

constexpr double kViewFocal_px = 191;
constexpr double kNear_m = 2, kFar_m = 3;
const std::array kNobody = {LandmarkId{900}, LandmarkId{901}, LandmarkId{902}};

/// Turns what is straight ahead to a direction this far from the axis.
Matrix3d TurnedBy(double angle_deg) {
  return ExpSO3(Vector3d(0.6, 0.8, 0) * (angle_deg * kDegree)).toRotationMatrix();
}

/// A triangle of about 23 deg across the direction that the rotation gives.
std::array<Vector3d, 3> WallTriangle(const Matrix3d& turned, double distance_m) {
  const double side = 0.2 * distance_m;
  return {turned * Vector3d(-side, -side, distance_m),
          turned * Vector3d(side, -side, distance_m),
          turned * Vector3d(0, side, distance_m)};
}

ProjectedFace ProjectWall(const ViewCheck& check, const std::array<Vector3d, 3>& corners) {
  return {check.Project(corners[0]), check.Project(corners[1]), check.Project(corners[2])};
}

/// A grid of points on a plane across that direction, and far to both sides of the axis, so that
/// the view is as wide as the lens.
MeshView ViewOf(const Matrix3d& turned, double distance_m) {
  MeshView view;
  view.focal_px = kViewFocal_px;
  std::int64_t id = 1;
  const auto add = [&](const Vector3d& p_C) {
    view.points.push_back({LandmarkId{id++}, p_C.normalized(), p_C, 0.01, 100});
  };
  for (int x = -3; x <= 3; ++x) {
    for (int y = -3; y <= 3; ++y)
      add(turned * Vector3d(0.1 * x * distance_m, 0.1 * y * distance_m, distance_m));
  }
  add(Vector3d(-1, -1, 1));
  add(Vector3d(1, 1, 1));
  return view;
}

class ViewCheckAtAngle : public ::testing::TestWithParam<double> {};

TEST_P(ViewCheckAtAngle, NewerFacesCoverOldOnesOfTheSameSurfaceOnly) {
  const Matrix3d turned = TurnedBy(GetParam());
  ViewCheck check;
  check.Begin(ViewOf(turned, kNear_m));
  check.Draw(ProjectWall(check, WallTriangle(turned, kNear_m)));
  EXPECT_TRUE(
      check.Judge(ProjectWall(check, WallTriangle(turned, 1.01 * kNear_m)), kNobody).is_covered);
  EXPECT_FALSE(check.Judge(ProjectWall(check, WallTriangle(turned, kFar_m)), kNobody).is_covered);
  const Matrix3d elsewhere = TurnedBy(GetParam() - 40);
  EXPECT_FALSE(
      check.Judge(ProjectWall(check, WallTriangle(elsewhere, kNear_m)), kNobody).is_covered);
}

TEST_P(ViewCheckAtAngle, AFaceBeforeWhatIsSeenIsSeenThrough) {
  const Matrix3d turned = TurnedBy(GetParam());
  ViewCheck check;
  check.Begin(ViewOf(turned, kFar_m));
  check.Draw(ProjectWall(check, WallTriangle(turned, kFar_m)));
  EXPECT_GE(
      check.Judge(ProjectWall(check, WallTriangle(turned, kNear_m)), kNobody).num_seen_through, 5);
  EXPECT_EQ(check.Judge(ProjectWall(check, WallTriangle(turned, kFar_m)), kNobody).num_seen_through,
            0);
  EXPECT_EQ(
      check.Judge(ProjectWall(check, WallTriangle(turned, 1.3 * kFar_m)), kNobody).num_seen_through,
      0);
}

INSTANTIATE_TEST_SUITE_P(FromTheAxis, ViewCheckAtAngle, ::testing::Values(0, 45, 80, 95, 105));

TEST(ViewCheck, SaysNothingOfWhatIsBehindALensThatSeesForwards) {
  ViewCheck check;
  check.Begin(ViewOf(TurnedBy(0), kFar_m));
  const FaceVisibility behind =
      check.Judge(ProjectWall(check, WallTriangle(TurnedBy(180), kNear_m)), kNobody);
  EXPECT_FALSE(behind.is_covered);
  EXPECT_EQ(behind.num_seen_through, 0);
}

// Nothing that is infinite, or against the axis, has a place.
TEST(ViewCheck, ProjectsWhatItCan) {
  ViewCheck check;
  check.Begin(ViewOf(TurnedBy(100), kFar_m));
  EXPECT_EQ(check.Project(Vector3d(0, 0, -1)).inverse_depth, 0);
  EXPECT_EQ(check.Project(Vector3d(0, 0, 0)).inverse_depth, 0);
  EXPECT_EQ(
      check.Project(Vector3d::Constant(std::numeric_limits<double>::quiet_NaN())).inverse_depth, 0);
  const ProjectedPoint beside = check.Project(Vector3d(4, 0, 0));
  EXPECT_NEAR(beside.xy.x(), 2, 1e-12);
  EXPECT_NEAR(beside.inverse_depth, 0.25, 1e-12);
}

}  // namespace
}  // namespace facet
