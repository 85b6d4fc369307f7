// SPDX-License-Identifier: BSD-2-Clause
// A yard between buildings, outdoors: sun, a sky without texture, fronts 10 to 40 m away, and some
// cars, trees and poles nearer by.
#include <algorithm>
#include <cmath>

#include "facet/geometry/so3.h"
#include "facet/render/floor_plan.h"
#include "facet/render/front_wall.h"
#include "facet/render/path_box.h"
#include "facet/render/scene_builder.h"

namespace facet {
namespace {

constexpr double kClearance = 1;
constexpr double kQuarterTurn = std::numbers::pi / 2;

SE3 Standing(double x, double y, double z = 0, double yaw = 0) {
  return {ExpSO3(Vector3d(0, 0, yaw)), {x, y, z}};
}

/// From the border of the path to the fronts.
struct Distances {
  double north = 10, east = 17, south = 30, west = 12;
};

void AddGround(ShapeBuilder& builder, const PathBox& yard) {
  const MaterialLibrary& m = builder.materials();
  const Vector3d half = 0.5 * yard.size;
  const auto lay =
      [&](const char* label, const char* material, const Vector3d& corner, double x, double y) {
        builder.AddPatch({label, m.Get(material), 0.5}, corner, {x, 0, 0}, {0, y, 0});
      };
  builder.Place(yard.T_WF);
  constexpr double kFar = 55;
  lay("ground", "asphalt", {-kFar, -kFar, 0}, 2 * kFar, 2 * kFar);
  const Distances d;
  lay("pavement",
      "paving",
      {-half.x() - 11, half.y() + d.north - 3.5, 0.1},
      2 * half.x() + 26,
      3.4);
  lay("lawn", "grass", {-half.x() - 8, -half.y() - 14, 0.06}, 2 * half.x() + 16, 9);
  lay("lawn", "grass", {half.x() + 7, -half.y(), 0.06}, 4, 2 * half.y());
  builder.AddBox({"kerb", m.Get("concrete"), 0.5},
                 {2, half.y() + d.north - 3.6, 0.05},
                 {2 * half.x() + 26, 0.2, 0.14});
  for (int i = 0; i < 9; ++i) {
    const double x = -half.x() - 6 + 3.0 * i;
    lay("line", "smooth_render", {x, half.y() + 2.5, 0.004}, 0.12, 4.5);
  }
}

void AddBuildings(ShapeBuilder& builder, const PathBox& yard) {
  const MaterialLibrary& m = builder.materials();
  const Vector3d half = 0.5 * yard.size;
  const Distances d;
  const auto build = [&](const SE3& T_FO, const Vector3d& size, const FrontStyle& style) {
    AddBuilding({builder, yard.T_WF * T_FO}, size, style);
  };
  // Their fronts look into the yard.
  const double north = half.y() + d.north, east = half.x() + d.east;
  build(Standing(-half.x() - 1, north, 0, 2 * kQuarterTurn),
        {20, 9, 13.5},
        {m.Get("facing_brick"), 3.3, 2.8, true, false});
  build(Standing(half.x() + 9, north + 1.5, 0, 2 * kQuarterTurn),
        {15, 9, 10.2},
        {m.Get("render"), 3.3, 3.4, true, true});
  build(
      Standing(east, 0, 0, kQuarterTurn), {30, 10, 16.5}, {m.Get("render"), 3.2, 3.1, true, true});
  build(Standing(-half.x() - d.west, 0, 0, -kQuarterTurn),
        {18, 8, 7},
        {m.Get("smooth_render"), 3.4, 6, false, false});
  build(Standing(-half.x() - d.west - 6, -24, 0, -kQuarterTurn),
        {20, 8, 12},
        {m.Get("facing_brick"), 3, 3.2, true, false});
  build(Standing(0, -half.y() - d.south, 0, 0),
        {46, 12, 19},
        {m.Get("facing_brick"), 3.1, 2.9, true, true});
  build(Standing(half.x() + 34, -half.y() - 26, 0, 0.6),
        {22, 10, 24},
        {m.Get("concrete"), 3, 3, false, true});
}

/// Where things may stand: not in the way.
struct Yard {
  ShapeBuilder& builder;
  const PathBox& box;
  std::span<const Vector3d> path_W;

  std::optional<SE3> Place(const SE3& T_FO, const Vector3d& size) const {
    const SE3 T_WO = box.T_WF * T_FO;
    if (!IsClearOfPath(path_W, T_WO, size, kClearance)) return std::nullopt;
    return T_WO;
  }
};

/// In the bays before the northern fronts and along the eastern one.
void AddCars(const Yard& yard) {
  Rng& rng = yard.builder.rng();
  const Vector3d half = 0.5 * yard.box.size;
  for (int i = 0; i < 9; ++i) {
    if (rng.Index(4) == 0) continue;
    const double x = -half.x() - 4.5 + 3.0 * i;
    const SE3 T_FO = Standing(
        x, half.y() + 4.7 + rng.Uniform(-0.3, 0.3), 0, kQuarterTurn + rng.Uniform(-0.04, 0.04));
    if (const auto T = yard.Place(T_FO, {4.2, 1.8, 1.5})) AddCar({yard.builder, *T});
  }
  for (int i = 0; i < 4; ++i) {
    const SE3 T_FO =
        Standing(half.x() + 14, -12 + 5.5 * i, 0, kQuarterTurn + rng.Uniform(-0.05, 0.05));
    if (const auto T = yard.Place(T_FO, {4.2, 1.8, 1.5})) AddCar({yard.builder, *T});
  }
}

/// On the lawns.
void AddTrees(const Yard& yard) {
  Rng& rng = yard.builder.rng();
  const Vector3d half = 0.5 * yard.box.size;
  for (int i = 0; i < 5; ++i) {
    const double height = rng.Uniform(4.5, 8);
    const SE3 T_FO =
        Standing(-half.x() - 5 + 5.5 * i, -half.y() - rng.Uniform(7, 12), 0, rng.Uniform(0, 6));
    if (const auto T = yard.Place(T_FO, {0.45 * height, 0.45 * height, height}))
      AddTree({yard.builder, *T}, height);
  }
  for (int i = 0; i < 3; ++i) {
    const double height = rng.Uniform(5, 7);
    const SE3 T_FO = Standing(half.x() + 9, -half.y() + 5.0 * i, 0, rng.Uniform(0, 6));
    if (const auto T = yard.Place(T_FO, {0.45 * height, 0.45 * height, height}))
      AddTree({yard.builder, *T}, height);
  }
}

/// Poles, railings and boxes.
void AddSmallThings(const Yard& yard) {
  Rng& rng = yard.builder.rng();
  const Vector3d half = 0.5 * yard.box.size;
  for (int i = 0; i < 8; ++i) {
    const bool has_sign = i % 2;
    const double height = has_sign ? 2.6 : 5.5;
    const double x = -half.x() - 7 + 4.0 * i, y = i % 3 == 0 ? -half.y() - 4.6 : half.y() + 7.5;
    const SE3 T_FO = Standing(x, y, 0, y > 0 ? 2 * kQuarterTurn : 0);
    if (const auto T = yard.Place(T_FO, {0.8, 0.8, height}))
      AddPole({yard.builder, *T}, height, has_sign);
  }
  for (int i = 0; i < 4; ++i) {
    const SE3 T_FO = Standing(-half.x() - 9, -8 + 4.0 * i, 0, kQuarterTurn);
    if (const auto T = yard.Place(T_FO, {3, 0.2, 1.1})) AddRailing({yard.builder, *T}, 3, 1.1);
  }
  for (int i = 0; i < 6; ++i) {
    const double side = rng.Uniform(0.5, 0.9);
    const SE3 T_FO =
        Standing(rng.Uniform(-1, 1) * (half.x() + 7), half.y() + 8.2 + rng.Uniform(-0.4, 0.4));
    if (const auto T = yard.Place(T_FO, {side, side, 2 * side}))
      AddBoxStack({yard.builder, *T}, side);
  }
}

}  // namespace

SceneModel BuildFacade(const ScenePlan& plan) {
  Rng rng(plan.seed);
  ShapeBuilder builder(plan.materials, Rng(rng.Next()));
  PathBox yard = BoundPath(plan.path_W, 0);
  yard.size = yard.size.cwiseMax(Vector3d(12, 8, 1));
  AddGround(builder, yard);
  AddBuildings(builder, yard);
  const Yard places{builder, yard, plan.path_W};
  AddCars(places);
  AddTrees(places);
  AddSmallThings(places);
  SceneModel scene;
  scene.lighting.ambient = 0.5;
  scene.lighting.occlusion_reach_m = 2;
  scene.lighting.sky = 1.6;
  // The sun: so far away that it is as bright everywhere.
  const double azimuth = rng.Uniform(-2.6, -0.6);
  constexpr double kDistance_m = 400;
  const Vector3d direction(std::cos(azimuth), std::sin(azimuth), 0.8);
  scene.lighting.lights.push_back(
      {kDistance_m * direction.normalized(), 1.5, 1.1 * kDistance_m * kDistance_m});
  scene.mesh = builder.TakeMesh();
  return scene;
}

std::vector<Vector3d> FacadeRoute(std::uint64_t seed) {
  Rng rng(seed + 5);
  const std::vector<Vector2d> points = {
      {-2, -3.5}, {3, -3.2}, {6, -1}, {5.5, 3}, {1, 3.6}, {-2, 1.5}, {-5.5, 3.2}, {-6, -2.5}};
  std::vector<Vector3d> route_W;
  for (const Vector2d& p : points) {
    route_W.emplace_back(
        p.x() + rng.Uniform(-0.4, 0.4), p.y() + rng.Uniform(-0.4, 0.4), rng.Uniform(1.3, 3));
  }
  route_W.push_back(route_W.front());
  return route_W;
}

}  // namespace facet
