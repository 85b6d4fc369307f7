// SPDX-License-Identifier: BSD-2-Clause
#include "facet/sim/flight.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace facet {
namespace {

std::vector<Vector3d> Walk(std::vector<Vector3d> route_W, double duration_s) {
  FlightOptions options;
  options.duration_s = duration_s;
  std::vector<Vector3d> path_W;
  for (const NavState& state : MakeFlightPoses(FlightKind::kWalk, route_W, options))
    path_W.push_back(state.T_WB.p);
  return path_W;
}

double NearestTo(const Vector3d& place, const std::vector<Vector3d>& path_W) {
  double nearest = 1e9;
  for (const Vector3d& p : path_W)
    nearest = std::min(nearest, (p - place).norm());
  return nearest;
}

TEST(FlightTest, AClosedRouteIsWalkedInLaps) {
  // A way of 6 m to a square of 4 m, which begins in its corner.
  const std::vector<Vector3d> route_W = {
      {-6, 0, 1}, {0, 0, 1}, {4, 0, 1}, {4, 4, 1}, {0, 4, 1}, {0, 0, 1}};
  const std::vector<Vector3d> path_W = Walk(route_W, 60);
  const std::vector<Vector3d> start(path_W.begin(), path_W.begin() + 600);
  EXPECT_LT(NearestTo({-5, 0, 1}, start), 1);
  // 60 s are more than two laps. It never goes back, and the way is walked once.
  const std::vector<Vector3d> laps(path_W.begin() + 2400, path_W.end());
  EXPECT_GT(NearestTo({-3, 0, 1}, laps), 2);
  double turned = 0;
  const Vector3d centre(2, 2, 1);
  for (std::size_t i = 1; i < laps.size(); ++i) {
    const Vector3d a = laps[i - 1] - centre, b = laps[i] - centre;
    turned += std::atan2(a.cross(b).z(), a.dot(b));
  }
  EXPECT_GT(turned, 1.5 * 2 * std::numbers::pi);
  for (std::size_t i = 1; i < path_W.size(); ++i)
    ASSERT_LT((path_W[i] - path_W[i - 1]).norm(), 0.02) << "it jumps at pose " << i;
}

TEST(FlightTest, AnOpenRouteIsWalkedBack) {
  const std::vector<Vector3d> path_W = Walk({{0, 0, 1}, {8, 0, 1}}, 16);
  EXPECT_LT(NearestTo({8, 0, 1}, path_W), 1);
  EXPECT_LT((path_W.back() - Vector3d(1, 0, 1)).norm(), 4);
}

TEST(FlightTest, TheSameEndTwiceIsNoLoop) {
  for (const Vector3d& p : Walk({{0, 0, 1}, {4, 0, 1}, {4, 0, 1}}, 12))
    ASSERT_TRUE(p.allFinite());
}

// The body's z axis is where the cameras look.
TEST(FlightTest, LooksDownByWhatIsAskedBesides) {
  const std::vector<Vector3d> route_W = {{0, 0, 1}, {8, 0, 1}};
  FlightOptions level, down;
  down.look_down = 0.7;
  const auto a = MakeFlightPoses(FlightKind::kHandHeld, route_W, level);
  const auto b = MakeFlightPoses(FlightKind::kHandHeld, route_W, down);
  ASSERT_EQ(a.size(), b.size());
  double change = 0;
  const auto elevation = [](const NavState& state) {
    return std::asin((state.T_WB.q * Vector3d::UnitZ()).z());
  };
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a[i].T_WB.p, b[i].T_WB.p);
    change += (elevation(a[i]) - elevation(b[i])) / static_cast<double>(a.size());
  }
  EXPECT_NEAR(change, 0.7, 0.02);
}

}  // namespace
}  // namespace facet
