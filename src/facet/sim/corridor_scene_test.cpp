// SPDX-License-Identifier: BSD-2-Clause
#include "facet/sim/corridor_scene.h"

#include <gtest/gtest.h>

namespace facet {
namespace {

TEST(CorridorSceneTest, SurfacesAreNumberedAndOrthonormal) {
  Rng rng(3);
  const auto surfaces = MakeCorridor({}, rng);
  ASSERT_GE(surfaces.size(), 10u + 5u);
  EXPECT_EQ((surfaces.size() - 10) % 5, 0u);  // whole cupboards
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    const Surface& s = surfaces[i];
    EXPECT_EQ(s.id, PlaneId{static_cast<std::int64_t>(i)});
    EXPECT_NEAR(s.n_W.norm(), 1, 1e-12);
    EXPECT_LT((s.u_W.cross(s.v_W) - s.n_W).norm(), 1e-12);
    EXPECT_GT(std::min(s.half_u, s.half_v), 0);
  }
}

TEST(CorridorSceneTest, TheFirstTenFaceTheRoute) {
  Rng rng(3);
  const CorridorOptions options;
  const auto surfaces = MakeCorridor(options, rng);
  const auto route_W = CorridorWalk(options, 1);
  for (std::size_t i = 0; i < 10; ++i) {
    double nearest = 1e9;
    for (const Vector3d& p_W : route_W)
      nearest = std::min(nearest, std::abs(surfaces[i].n_W.dot(p_W) - surfaces[i].d_W()));
    EXPECT_LT(nearest, 1.5) << i;
  }
  // In the middle of a long side: walls to both sides at half the corridor's width.
  const RoomScene scene(surfaces);
  for (const double side : {-1.0, 1.0}) {
    const Vector3d across =
        Eigen::AngleAxisd(options.heading_rad, Vector3d::UnitZ()) * Vector3d(0, side, 0);
    const auto hit = scene.CastRay(route_W.front(), across);
    ASSERT_TRUE(hit.has_value());
    EXPECT_LE(hit->distance, options.width_m / 2 + 1e-9);
    EXPECT_GE(hit->distance, options.width_m / 2 - options.cupboard_depth_m - 1e-9);
  }
}

TEST(CorridorSceneTest, CupboardsStandOutByTheirDepth) {
  Rng rng(5);
  CorridorOptions options;
  options.cupboard_depth_m = 0.1;
  const auto surfaces = MakeCorridor(options, rng);
  for (std::size_t front = 10; front < surfaces.size(); front += 5) {
    const bool is_parallel_to_a_wall =
        std::any_of(surfaces.begin() + 2, surfaces.begin() + 10, [&](const Surface& wall) {
          return wall.n_W.dot(surfaces[front].n_W) > 1 - 1e-12 &&
                 std::abs(surfaces[front].d_W() - wall.d_W() - 0.1) < 1e-9;
        });
    EXPECT_TRUE(is_parallel_to_a_wall) << front;
  }
}

TEST(CorridorSceneTest, TheRouteClosesAfterEveryLap) {
  const CorridorOptions options;
  const auto route_W = CorridorWalk(options, 2);
  EXPECT_LT((route_W.front() - route_W.back()).norm(), 1e-12);
  double length = 0;
  for (std::size_t i = 1; i < route_W.size(); ++i)
    length += (route_W[i] - route_W[i - 1]).norm();
  EXPECT_NEAR(length, 4 * (options.length_m + options.depth_m), 1e-9);
}

}  // namespace
}  // namespace facet
