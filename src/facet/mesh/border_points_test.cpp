// SPDX-License-Identifier: BSD-2-Clause
#include "facet/mesh/border_points.h"

#include <limits>

#include <gtest/gtest.h>

#include "facet/base/random.h"

namespace facet {
namespace {

const Vector3d kNormal_C = Vector3d(0.3, -0.2, 1).normalized();
constexpr double kOffset_m = 2;

/// The bearing of a point of the plane z = 1.
Vector3d Place(double x, double y) {
  return Vector3d(x, y, 1).normalized();
}

/// A grid of points on a slanted plane, 40 px apart, that ends at x = 0.
MeshView SlantedPlane(double sigma_m) {
  MeshView view;
  view.focal_px = 460;
  for (int i = 0; i < 36; ++i) {
    const Vector2d xy(-40.0 / 460 * (i % 6), 40.0 / 460 * (i / 6 - 3));
    const Vector3d ray(xy.x(), xy.y(), 1);
    view.points.push_back(
        {LandmarkId{i}, ray.normalized(), kOffset_m / kNormal_C.dot(ray) * ray, sigma_m, 100});
  }
  return view;
}

TEST(BorderPoints, ContinueAPlane) {
  BorderPoints border;
  for (double y : {-0.1, 0.0, 0.05}) {
    const auto point = border.Continue(SlantedPlane(0.01), Place(0.08, y));
    ASSERT_TRUE(point);
    EXPECT_NEAR(kNormal_C.dot(point->p_C), kOffset_m, 1e-9);
    EXPECT_NEAR(point->p_C.x() / point->p_C.z(), 0.08, 1e-12);
    EXPECT_EQ(point->intensity, 100);
  }
}

TEST(BorderPoints, SayHowUncertainTheyAre) {
  Rng rng(1);
  BorderLimits limits;
  limits.max_depth_sigma = 1;
  limits.max_sigmas = 100;
  BorderPoints border(limits);
  double sum = 0, stated = 0;
  constexpr int kTrials = 2000;
  for (int trial = 0; trial < kTrials; ++trial) {
    MeshView view = SlantedPlane(0.01);
    for (MeshPoint& point : view.points)
      point.p_C *= 1 + 0.01 * rng.Normal() / point.p_C.norm();
    const auto point = border.Continue(view, Place(0.08, 0.02));
    ASSERT_TRUE(point);
    const Vector3d ray = point->p_C.normalized();
    const double error = point->p_C.norm() - kOffset_m / kNormal_C.dot(ray);
    sum += error * error / kTrials;
    stated += point->sigma_depth_m * point->sigma_depth_m / kTrials;
  }
  EXPECT_NEAR(sum / stated, 1, 0.12);
}

TEST(BorderPoints, NoneWhereThePlaneEndsOrIsFarOrBadlyKnown) {
  BorderPoints border;
  MeshView step = SlantedPlane(0.01);
  for (MeshPoint& point : step.points) {
    if (point.bearing.y() > 0.01) point.p_C *= 1.3;
  }
  EXPECT_FALSE(border.Continue(step, Place(0.04, 0)))
      << "an edge passes between the nearest points";
  EXPECT_FALSE(border.Continue(SlantedPlane(0.01), Place(0.5, 0))) << "too far away";
  EXPECT_FALSE(border.Continue(SlantedPlane(0.2), Place(0.08, 0))) << "the slope is hardly known";
  EXPECT_FALSE(border.Continue(MeshView(), Place(0, 0)));
}

TEST(BorderPoints, IgnoreWhatIsNoPoint) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  MeshView view = SlantedPlane(0.01);
  view.points.push_back({LandmarkId{50}, Place(0.08, 0), {kNan, 0, 1}, 0.01, 0});
  view.points.push_back({LandmarkId{51}, Place(0.08, 0), {0, 0, -1}, 0.01, 0});
  view.points.push_back({LandmarkId{52}, Place(kNan, 0), {0, 0, 1}, 0.01, 0});
  view.points.push_back({LandmarkId{53}, Place(0.08, 0), {0, 0, 1}, kNan, 0});
  const auto point = BorderPoints(BorderLimits()).Continue(view, Place(0.08, 0));
  ASSERT_TRUE(point);
  EXPECT_NEAR(kNormal_C.dot(point->p_C), kOffset_m, 1e-9);
  // All points in one place or on one line say nothing about a plane.
  EXPECT_FALSE(BorderPoints(BorderLimits()).Continue(view, Place(0.02, 0)))
      << "there is one already";
  MeshView line = SlantedPlane(0.01);
  for (MeshPoint& p : line.points)
    p = line.points[0];
  const auto from_one_place = BorderPoints(BorderLimits()).Continue(line, Place(0.08, -0.2));
  EXPECT_FALSE(from_one_place);
}

}  // namespace
}  // namespace facet
