// SPDX-License-Identifier: BSD-2-Clause
// A machine hall: rows of machines, racks and pallets, columns, pipes and cable trays, one large
// wall of render and one of bricks. Half of the ground is level, the other half slightly uneven.
#include <algorithm>
#include <cmath>

#include "facet/geometry/so3.h"
#include "facet/render/floor_plan.h"
#include "facet/render/machinery.h"
#include "facet/render/path_box.h"
#include "facet/render/scene_builder.h"
#include "facet/render/waves.h"

namespace facet {
namespace {

constexpr double kClearance = 0.6;
constexpr double kQuarterTurn = std::numbers::pi / 2;
constexpr double kBump_m = 0.03;  // 1-sigma of the uneven ground, about

SE3 Standing(double x, double y, double z = 0, double yaw = 0) {
  return {ExpSO3(Vector3d(0, 0, yaw)), {x, y, z}};
}

PathBox FitHall(std::span<const Vector3d> path_W) {
  PathBox box = BoundPath(path_W, 0);
  box.size = Vector3d(std::max(30.0, box.size.x() + 8),
                      std::max(20.0, box.size.y() + 8),
                      std::max(8.0, box.size.z() + 2));
  return box;
}

void AddGround(ShapeBuilder& builder, const PathBox& hall) {
  const MaterialLibrary& m = builder.materials();
  const Vector3d half = 0.5 * hall.size;
  builder.Place(hall.T_WF);
  builder.AddPatch({"floor", m.Get("concrete"), 0.3},
                   {-half.x(), -half.y(), 0},
                   {half.x(), 0, 0},
                   {0, hall.size.y(), 0});
  const Waves bumps(4, 4, builder.rng());
  const int columns = static_cast<int>(half.x() / 0.2), rows = static_cast<int>(half.y() / 0.1);
  builder.AddCurved(
      {"ground", m.Get("soil")}, {columns, rows, half.x(), hall.size.y()}, [&](double s, double t) {
        const double x = half.x() * s, y = hall.size.y() * (t - 0.5);
        const double rise = std::min(1.0, x / 1.5);  // level where both meet
        return Vector3d(x, y, rise * kBump_m * (bumps.At({x, y, 0}) - 0.5));
      });
}

void AddShell(ShapeBuilder& builder, const PathBox& hall) {
  const MaterialLibrary& m = builder.materials();
  const Vector3d half = 0.5 * hall.size;
  builder.Place(hall.T_WF);
  builder.AddPatch({"ceiling", m.Get("sheeting"), 0.5},
                   {-half.x(), half.y(), hall.size.z()},
                   {hall.size.x(), 0, 0},
                   {0, -hall.size.y(), 0});
  const char* const kFinish[] = {"render", "sheeting", "facing_brick", "concrete"};
  for (int wall = 0; wall < 4; ++wall) {
    const double width = hall.size(wall % 2), depth = half(1 - wall % 2);
    builder.Place(hall.T_WF * Standing(0, 0, 0, kQuarterTurn * wall));
    builder.AddPatch({"wall", m.Get(kFinish[wall]), 0.35},
                     {width / 2, -depth, -0.3},
                     {-width, 0, 0},
                     {0, 0, hall.size.z() + 0.3});
    for (double x = -width / 2 + 2.5; x < width / 2 - 1; x += 5)
      AddColumn({builder,
                 hall.T_WF * Standing(0, 0, 0, kQuarterTurn * wall) * Standing(x, -depth + 0.18)},
                hall.size.z());
  }
}

/// Lamps in rows below beams under the roof, and a band of windows high on the long walls.
Lighting AddLamps(ShapeBuilder& builder, const PathBox& hall) {
  const MaterialLibrary& m = builder.materials();
  Lighting lighting;
  lighting.ambient = 0.6;
  lighting.occlusion_reach_m = 1.5;
  for (double x = -0.4; x < 0.45; x += 0.2) {
    builder.Place(hall.T_WF);
    const double z = hall.size.z() - 0.35, x_F = x * hall.size.x();
    builder.AddBox({"beam", m.Get("metal"), 0.4}, {x_F, 0, z}, {0.25, hall.size.y() - 0.1, 0.5});
    for (const double y : {-0.3, 0.0, 0.3}) {
      const Vector3d p_F(x_F, y * hall.size.y(), z - 0.35);
      builder.AddBox({"lamp", m.Get("lamp"), 0.5}, p_F, {0.4, 1.2, 0.08});
      lighting.lights.push_back(
          {hall.T_WF * Vector3d(p_F - Vector3d(0, 0, 0.15)), 0.5, builder.rng().Uniform(6, 11)});
    }
  }
  for (const double side : {0.0, 2.0}) {
    for (double x = -0.5 * hall.size.x() + 5; x < 0.5 * hall.size.x() - 4; x += 5) {
      const SE3 T_FO = Standing(0, 0, 0, kQuarterTurn * side) *
                       Standing(x, -hall.size.y() / 2 + 0.01, hall.size.z() - 2.2);
      AddPanel({builder, hall.T_WF * T_FO}, "window", {3.2, 1.1}, m.Get("lamp"));
    }
  }
  return lighting;
}

/// Pipes and cable trays along the walls and below the roof; signs and doors.
void AddWallThings(ShapeBuilder& builder, FloorPlan& plan, const PathBox& hall) {
  Rng& rng = builder.rng();
  const MaterialLibrary& m = builder.materials();
  const Vector3d half = 0.5 * hall.size;
  for (int i = 0; i < 5; ++i) {
    const double y = (i % 2 ? 1 : -1) * (half.y() - 0.45 - 0.15 * i);
    const double z = rng.Uniform(0.45, 0.75) * hall.size.z();
    AddPipe({builder, hall.T_WF * Standing(-half.x() + 0.05, y, z)},
            rng.Uniform(0.06, 0.16),
            hall.size.x() - 0.1);
  }
  for (int i = 0; i < 4; ++i) {
    const SE3 T_FO = Standing(rng.Uniform(-0.9, 0.9) * half.x(),
                              -half.y() + 0.1,
                              hall.size.z() - rng.Uniform(0.8, 1.4),
                              kQuarterTurn);
    AddPipe({builder, hall.T_WF * T_FO}, rng.Uniform(0.08, 0.2), hall.size.y() - 0.2);
  }
  for (int i = 0; i < 24; ++i) {
    const double width = rng.Uniform(0.5, 1.5);
    const Vector2d size(width, width * rng.Uniform(0.6, 1.3));
    if (const auto T = plan.FindOnWall(size, 1.3, 4, rng))
      AddPanel({builder, *T}, "sign", size, m.RandomPicture(rng));
  }
  for (int i = 0; i < 3; ++i) {
    if (const auto T = plan.FindOnWall({3, 3.2}, 1.6, 1.61, rng))
      AddPanel({builder, *T}, "gate", {3, 3.2}, m.Get("sheeting"));
  }
}

/// Two rows in the middle, racks along the walls, and single machines.
void AddMachines(ShapeBuilder& builder, FloorPlan& plan, const PathBox& hall) {
  Rng& rng = builder.rng();
  for (const double row : {-0.02, 0.02}) {
    for (double x = -0.4; x < 0.42; x += 0.11) {
      const Vector3d size(rng.Uniform(1.4, 2.8), rng.Uniform(1.1, 1.5), rng.Uniform(1.2, 2.6));
      const double yaw = (row > 0 ? 0 : 2 * kQuarterTurn) + rng.Uniform(-0.05, 0.05);
      const double y = row * hall.size.y() + (row > 0 ? 1 : -1) * 0.6;
      if (const auto T = plan.TakeBox(Standing(x * hall.size.x(), y, 0, yaw), size))
        AddMachine({builder, *T}, size);
    }
  }
  for (int i = 0; i < 7; ++i) {
    const Vector3d rack(rng.Uniform(2.2, 3.2), 0.9, rng.Uniform(2, 4));
    if (const auto T = plan.Find({rack, true, 0.4}, rng)) AddRack({builder, *T}, rack);
  }
  for (int i = 0; i < 10; ++i) {
    const Vector3d size(rng.Uniform(1.3, 2.6), rng.Uniform(1.1, 1.4), rng.Uniform(1.1, 2.4));
    if (const auto T = plan.Find({size, i < 6, 0.5}, rng)) AddMachine({builder, *T}, size);
  }
}

/// Whatever else stands about, and marks on the level half.
void AddLooseThings(ShapeBuilder& builder, FloorPlan& plan, const PathBox& hall) {
  Rng& rng = builder.rng();
  for (int i = 0; i < 16; ++i) {
    if (const auto T = plan.Find({{1.2, 1.2, 2}, i % 2 == 0, 0.5}, rng))
      AddPallet({builder, *T}, rng.Uniform(0.9, 1.2));
  }
  for (int i = 0; i < 12; ++i) {
    const double side = rng.Uniform(0.4, 0.9);
    if (const auto T = plan.Find({{1.2 * side, 1.2 * side, 2 * side}, false}, rng))
      AddBoxStack({builder, *T}, side);
  }
  for (int i = 0; i < 6; ++i) {
    const double width = rng.Uniform(1.5, 3);
    if (const auto T = plan.Find({{width, 0.15, 1.15}, false}, rng))
      AddRailing({builder, *T}, width, 1.1);
  }
  const MaterialLibrary& m = builder.materials();
  for (int i = 0; i < 8; ++i) {
    const SE3 T_FO = Standing(
        -rng.Uniform(1, 14), rng.Uniform(-8, 8), 0.002 + 0.001 * i, kQuarterTurn * rng.Index(2));
    AddMat({builder, hall.T_WF * T_FO}, "tape", {0.12, rng.Uniform(2, 5)}, m.Get("tape"));
  }
}

}  // namespace

SceneModel BuildHall(const ScenePlan& plan) {
  Rng rng(plan.seed);
  ShapeBuilder builder(plan.materials, Rng(rng.Next()));
  const PathBox hall = FitHall(plan.path_W);
  FloorPlan floor(hall.T_WF, 0.5 * hall.size.head<2>(), plan.path_W, kClearance);
  AddGround(builder, hall);
  AddShell(builder, hall);
  SceneModel scene;
  scene.lighting = AddLamps(builder, hall);
  AddWallThings(builder, floor, hall);
  AddMachines(builder, floor, hall);
  AddLooseThings(builder, floor, hall);
  scene.mesh = builder.TakeMesh();
  return scene;
}

std::vector<Vector3d> HallRoute(std::uint64_t seed) {
  Rng rng(seed + 4);
  // Laps around the rows of machines in the middle.
  const std::vector<Vector2d> points = {{-4, -4.2},
                                        {4, -4.6},
                                        {11.5, -4.4},
                                        {13, 0},
                                        {11.5, 4.6},
                                        {4, 4.3},
                                        {-4, 4.8},
                                        {-11.5, 4.4},
                                        {-13, 0},
                                        {-11.5, -4.5}};
  std::vector<Vector3d> route_W;
  for (const Vector2d& p : points)
    route_W.emplace_back(p.x(), p.y() + rng.Uniform(-0.4, 0.4), rng.Uniform(1.3, 2.8));
  route_W.push_back(route_W.front());
  return route_W;
}

}  // namespace facet
