// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/track/plane_extent.h"

#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/geometry/so3.h"

namespace facet {
namespace {

// A rectangle as two triangles, somewhere on a tilted plane.
struct Rectangle {
  Plane plane_W;
  Vector3d centre_W;
  Vector3d half_a_W, half_b_W;

  Rectangle(const Vector3d& n, double size_a_m, double size_b_m) {
    plane_W = {n.normalized(), 4.0};
    centre_W = 4.0 * plane_W.n;
    const Matrix<3, 2> B = TangentBasis(plane_W.n);
    half_a_W = 0.5 * size_a_m * (0.8 * B.col(0) + 0.6 * B.col(1));
    half_b_W = 0.5 * size_b_m * (-0.6 * B.col(0) + 0.8 * B.col(1));
  }
  Vector3d At(double a, double b) const { return centre_W + a * half_a_W + b * half_b_W; }
  void AddTo(PlaneExtent& extent) const {
    extent.AddTriangle({At(-1, -1), At(1, -1), At(1, 1)});
    extent.AddTriangle({At(-1, 1), At(-1, -1), At(1, 1)});
  }
};

TEST(PlaneExtentTest, AreaIsThatOfTheRectangle) {
  for (const Vector3d& n : {Vector3d(0, 0, 1), Vector3d(1, 0, 0), Vector3d(1, -2, 0.7)}) {
    const Rectangle rectangle(n, 3, 2);
    PlaneExtent extent(rectangle.plane_W, rectangle.centre_W);
    EXPECT_EQ(extent.area_m2(), 0);
    rectangle.AddTo(extent);
    EXPECT_NEAR(extent.area_m2(), 6, 0.2);
    // Seen again, it is not more.
    rectangle.AddTo(extent);
    EXPECT_NEAR(extent.area_m2(), 6, 0.2);
    EXPECT_LT((extent.Centroid(rectangle.plane_W) - rectangle.centre_W).norm(), 0.03);
  }
}

TEST(PlaneExtentTest, SmallFacesAddUp) {
  const Rectangle whole(Vector3d(0.2, 1, 0), 2, 2);
  PlaneExtent extent(whole.plane_W, whole.centre_W);
  for (int i = 0; i < 20; ++i) {
    for (int j = 0; j < 20; ++j) {
      const double a = -1 + 0.1 * i, b = -1 + 0.1 * j;
      extent.AddTriangle({whole.At(a, b), whole.At(a + 0.1, b), whole.At(a + 0.1, b + 0.1)});
      extent.AddTriangle({whole.At(a, b), whole.At(a + 0.1, b + 0.1), whole.At(a, b + 0.1)});
    }
  }
  EXPECT_NEAR(extent.area_m2(), 4, 0.15);
}

TEST(PlaneExtentTest, HasSurfaceWithinACell) {
  const Rectangle rectangle({0.3, -0.5, 0.8}, 2, 1);
  PlaneExtent extent(rectangle.plane_W, rectangle.centre_W);
  EXPECT_FALSE(extent.HasSurface(rectangle.centre_W));
  rectangle.AddTo(extent);
  for (const double a : {-0.95, -0.3, 0.4, 0.95}) {
    for (const double b : {-0.9, 0.0, 0.9})
      EXPECT_TRUE(extent.HasSurface(rectangle.At(a, b))) << a << " " << b;
  }
  EXPECT_TRUE(extent.HasSurface(rectangle.centre_W + 3 * rectangle.plane_W.n));
  for (const double a : {-1.3, 1.3})
    EXPECT_FALSE(extent.HasSurface(rectangle.At(a, 0))) << "30 cm beyond";
  EXPECT_FALSE(extent.HasSurface(Vector3d::Constant(std::nan(""))));
}

TEST(PlaneExtentTest, IsNearKnowsHoles) {
  const Rectangle rectangle(Vector3d(0, 0, 1), 2, 2);
  PlaneExtent extent(rectangle.plane_W, rectangle.centre_W);
  EXPECT_FALSE(extent.IsNear(rectangle.centre_W, 2));
  rectangle.AddTo(extent);
  EXPECT_TRUE(extent.IsNear(rectangle.centre_W, 0.5));
  // The distance from the plane does not count.
  EXPECT_TRUE(extent.IsNear(rectangle.centre_W + 9 * rectangle.plane_W.n, 0.5));
  EXPECT_TRUE(extent.IsNear(rectangle.At(1.3, 0), 0.5));
  EXPECT_FALSE(extent.IsNear(rectangle.At(3.2, 0), 0.5));
  EXPECT_TRUE(extent.IsNear(rectangle.At(3.2, 0), 2.5));
  EXPECT_FALSE(extent.IsNear(rectangle.At(6, 0), 2.5));
}

TEST(PlaneExtentTest, OutlineEnclosesTheSurfaceCounterClockwise) {
  Rng rng(1);
  for (int run = 0; run < 20; ++run) {
    const Rectangle rectangle(rng.UnitVector(), 3, 1.5);
    PlaneExtent extent(rectangle.plane_W, rectangle.centre_W);
    rectangle.AddTo(extent);
    for (const double sign : {1.0, -1.0}) {
      const Plane plane{sign * rectangle.plane_W.n, sign * rectangle.plane_W.d};
      const std::vector<Vector3d> outline = extent.Outline(plane);
      ASSERT_GE(outline.size(), 4u);
      double area = 0;
      for (std::size_t k = 0; k < outline.size(); ++k) {
        const Vector3d& a = outline[k];
        const Vector3d& b = outline[(k + 1) % outline.size()];
        EXPECT_NEAR(plane.SignedDistance(a), 0, 1e-9);
        area += 0.5 * plane.n.dot((a - rectangle.centre_W).cross(b - rectangle.centre_W));
        for (const double s : {-0.95, 0.95}) {
          for (const double t : {-0.9, 0.9}) {
            const Vector3d inside = rectangle.At(s, t);
            EXPECT_GT(plane.n.dot((b - a).cross(inside - a)), 0);
          }
        }
      }
      EXPECT_NEAR(area, 4.5, 0.7);
    }
  }
}

TEST(PlaneExtentTest, FollowsTheEstimateWithoutMovingItsCells) {
  const Rectangle rectangle(Vector3d(0, 0, 1), 2, 2);
  PlaneExtent extent(rectangle.plane_W, rectangle.centre_W);
  rectangle.AddTo(extent);
  const Plane moved{Vector3d(0.01, 0, 1).normalized(), 4.03};
  EXPECT_NEAR(moved.SignedDistance(extent.Centroid(moved)), 0, 1e-12);
  for (const Vector3d& corner : extent.Outline(moved))
    EXPECT_NEAR(moved.SignedDistance(corner), 0, 1e-12);
}

TEST(PlaneExtentTest, HugeAndUndefinedTrianglesAreLeftOut) {
  PlaneExtent extent({Vector3d::UnitZ(), 0}, Vector3d::Zero());
  extent.AddTriangle({Vector3d::Zero(), Vector3d(1e6, 0, 0), Vector3d(0, 1e6, 0)});
  extent.AddTriangle({Vector3d::Zero(), Vector3d(1e300, 0, 0), Vector3d(0, 1, 0)});
  extent.AddTriangle(
      {Vector3d::Zero(), Vector3d::Constant(std::nan("")), Vector3d::Constant(std::nan(""))});
  EXPECT_EQ(extent.area_m2(), 0);
  extent.AddTriangle({Vector3d::Zero(), Vector3d(1, 0, 0), Vector3d(0, 1, 0)});
  const double area_m2 = extent.area_m2();
  EXPECT_GT(area_m2, 0.3);
  const Vector3d far(3000, 3000, 0);
  extent.AddTriangle({far, far + Vector3d(1, 0, 0), far + Vector3d(0, 1, 0)});
  EXPECT_EQ(extent.area_m2(), area_m2);
  for (const Vector3d& p_W : {Vector3d(0.1, 0.1, 0), Vector3d(0.6, 0.1, 0), Vector3d(0.1, 0.6, 0)})
    extent.Remove(p_W);
  EXPECT_LT(extent.area_m2(), area_m2 - 0.1);
  for (double x = 0; x < 1; x += 0.1) {
    for (double y = 0; y < 1; y += 0.1)
      extent.Remove(Vector3d(x, y, 0));
  }
  EXPECT_EQ(extent.area_m2(), 0);
  EXPECT_FALSE(extent.IsNear(Vector3d(1e300, 0, 0), 1));
  EXPECT_FALSE(extent.IsNear(Vector3d::Constant(std::nan("")), 1));
  EXPECT_TRUE(extent.Outline({Vector3d::UnitZ(), 0}).empty());
}

}  // namespace
}  // namespace facet
