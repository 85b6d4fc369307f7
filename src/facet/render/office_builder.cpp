// SPDX-License-Identifier: BSD-2-Clause
// An office: islands of desks with screens in the middle, shelves, whiteboards and pictures along
// the walls, a meeting table, drawing boards and a ramp.
#include <algorithm>
#include <cmath>

#include "facet/geometry/so3.h"
#include "facet/render/floor_plan.h"
#include "facet/render/furniture.h"
#include "facet/render/path_box.h"
#include "facet/render/scene_builder.h"

namespace facet {
namespace {

constexpr double kClearance = 0.4;
constexpr double kQuarterTurn = std::numbers::pi / 2;
constexpr double kDegree = std::numbers::pi / 180;

SE3 Standing(double x, double y, double z = 0, double yaw = 0) {
  return {ExpSO3(Vector3d(0, 0, yaw)), {x, y, z}};
}

/// Aligned with the axes of the path, or as near to them as it goes: the route knows the islands.
PathBox FitOffice(std::span<const Vector3d> path_W) {
  PathBox box = BoundPath(path_W, 0);
  box.size = Vector3d(std::max(12.0, box.size.x() + 2.6),
                      std::max(8.0, box.size.y() + 2.6),
                      std::max(3.2, box.size.z() + 0.9));
  return box;
}

void AddShell(ShapeBuilder& builder, const PathBox& room) {
  const MaterialLibrary& m = builder.materials();
  const Vector3d half = 0.5 * room.size;
  constexpr double kCell = 0.12;
  builder.Place(room.T_WF);
  builder.AddPatch({"floor", m.Get("carpet"), kCell},
                   {-half.x(), -half.y(), 0},
                   {room.size.x(), 0, 0},
                   {0, room.size.y(), 0});
  builder.AddPatch({"ceiling", m.Get("smooth_render"), kCell},
                   {-half.x(), half.y(), room.size.z()},
                   {room.size.x(), 0, 0},
                   {0, -room.size.y(), 0});
  const char* const kFinish[] = {"plaster", "rough_plaster", "plaster", "boards"};
  for (int wall = 0; wall < 4; ++wall) {
    const double width = room.size(wall % 2), depth = half(1 - wall % 2);
    builder.Place(room.T_WF * Standing(0, 0, 0, kQuarterTurn * wall));
    builder.AddPatch({"wall", m.Get(kFinish[wall]), kCell},
                     {width / 2, -depth, 0},
                     {-width, 0, 0},
                     {0, 0, room.size.z()});
    builder.AddBox({"skirting", m.Get("wood")}, {0, -depth + 0.01, 0.05}, {width, 0.02, 0.1});
  }
}

/// Rows of lamp panels under the ceiling, and windows on one long wall.
Lighting AddLamps(ShapeBuilder& builder, FloorPlan& plan, const PathBox& room) {
  Lighting lighting;
  lighting.ambient = 0.34;
  const int lamp = builder.materials().Get("lamp");
  for (double x = -0.35; x < 0.4; x += 0.35) {
    for (const double y : {-0.22, 0.22}) {
      const Vector3d p_F(x * room.size.x(), y * room.size.y(), room.size.z() - 0.05);
      builder.Place(room.T_WF * SE3(Quaterniond::Identity(), p_F));
      builder.AddBox({"lamp", lamp, 0.5}, {0, 0, 0}, {1.2, 0.3, 0.05});
      lighting.lights.push_back(
          {room.T_WF * Vector3d(p_F - Vector3d(0, 0, 0.12)), 0.4, builder.rng().Uniform(1, 2)});
    }
  }
  for (int i = 0; i < 3; ++i) {
    const Vector2d window(1.3, 1.3);
    const auto T_WO = plan.FindOnWall(window, 1.5, 1.8, builder.rng());
    if (!T_WO) continue;
    AddPanel({builder, *T_WO}, "window", window, lamp);
    lighting.lights.push_back({*T_WO * Vector3d(0, 0.3, 0), 0.5, 1.5});
  }
  return lighting;
}

void AddWallThings(ShapeBuilder& builder, FloorPlan& plan) {
  Rng& rng = builder.rng();
  const MaterialLibrary& m = builder.materials();
  const auto hang = [&](const char* label, const Vector2d& size, double z, int material) {
    const auto T_WO = plan.FindOnWall(size, z, z + 0.3, rng);
    if (T_WO) AddPanel({builder, *T_WO}, label, size, material);
  };
  for (int i = 0; i < 3; ++i)
    hang("whiteboard", {rng.Uniform(1.4, 2.2), 1.1}, 1.4, m.Get("whiteboard"));
  for (int i = 0; i < 2; ++i)
    hang("door", {0.95, 2.05}, 1.03, m.Get("wood"));
  for (int i = 0; i < 12; ++i) {
    const double width = rng.Uniform(0.35, 0.9);
    hang("poster", {width, width * rng.Uniform(0.7, 1.4)}, 1.4, m.RandomPicture(rng));
  }
}

/// Two rows of desks that face each other, with screens back to back; chairs in front of them.
void AddIsland(ShapeBuilder& builder, FloorPlan& plan, double x, double y) {
  Rng& rng = builder.rng();
  for (const double side : {-1.0, 1.0}) {
    for (const double at : {-0.82, 0.82}) {
      const Vector3d desk(1.6, 0.8, rng.Uniform(0.71, 0.75));
      const SE3 T_FO = Standing(x + at, y + 0.42 * side, 0, side > 0 ? 0 : 2 * kQuarterTurn);
      const auto T_WO = plan.TakeBox(T_FO, {desk.x(), desk.y(), desk.z() + 0.5});
      if (T_WO) AddDesk({builder, *T_WO}, desk);
      const SE3 T_FC = Standing(x + at + rng.Uniform(-0.25, 0.25),
                                y + side * rng.Uniform(1.05, 1.15),
                                0,
                                (side > 0 ? 2 * kQuarterTurn : 0) + rng.Uniform(-0.5, 0.5));
      if (const auto T_WC = plan.TakeBox(T_FC, {0.45, 0.45, 0.9})) AddChair({builder, *T_WC});
    }
  }
}

/// Along the walls, where there is room.
void AddWallFurniture(ShapeBuilder& builder, FloorPlan& plan) {
  Rng& rng = builder.rng();
  const MaterialLibrary& m = builder.materials();
  const auto find = [&](const Vector3d& size) { return plan.Find({size, true, 0.03}, rng); };
  for (int i = 0; i < 5; ++i) {
    const Vector3d shelf(rng.Uniform(0.8, 1.4), 0.36, rng.Uniform(1.1, 2.1));
    if (const auto T = find(shelf)) AddShelf({builder, *T}, shelf);
  }
  for (int i = 0; i < 2; ++i) {
    const Vector3d size(rng.Uniform(1.1, 1.4), 0.7, 1.1);
    if (const auto T = find(size)) AddDrawingTable({builder, *T}, rng.Uniform(15, 30) * kDegree);
  }
  for (int i = 0; i < 2; ++i) {
    const double lean = rng.Uniform(6, 14) * kDegree;
    const Vector2d board(rng.Uniform(0.9, 1.3), rng.Uniform(1.3, 1.8));
    const double depth = board.y() * std::sin(lean) + 0.05;
    if (const auto T = find({board.x(), depth, board.y()})) {
      const SE3 foot(Quaterniond::Identity(), {0, depth / 2, 0.001});
      AddLeaningBoard({builder, *T * foot}, board, m.RandomPicture(rng), lean);
    }
  }
  for (int i = 0; i < 3; ++i) {
    const Vector3d cabinet(rng.Uniform(0.8, 1.2), 0.45, rng.Uniform(0.7, 1.3));
    const auto T = find(cabinet);
    if (!T) continue;
    builder.Place(*T);
    builder.AddBox({"cabinet", m.Get("machine")}, {0, 0, cabinet.z() / 2}, cabinet);
  }
}

/// What stands about: a meeting table with chairs, a ramp, boxes, plants.
void AddLooseThings(ShapeBuilder& builder, FloorPlan& plan) {
  Rng& rng = builder.rng();
  const auto find = [&](const Vector3d& size) { return plan.Find({size, false}, rng); };
  if (const auto T = find({1.8, 0.9, 1})) AddTable({builder, *T}, {1.8, 0.9, 0.74});
  for (int i = 0; i < 2; ++i) {
    const double rise = rng.Uniform(0.12, 0.3);
    if (const auto T = find({1.4, 0.9, rise})) AddRamp({builder, *T}, {1.4, 0.9, rise});
  }
  for (int i = 0; i < 5; ++i) {
    if (const auto T = find({0.5, 0.5, 0.95})) AddChair({builder, *T});
  }
  for (int i = 0; i < 4; ++i) {
    const double side = rng.Uniform(0.3, 0.5);
    if (const auto T = find({1.2 * side, 1.2 * side, 2 * side})) AddBoxStack({builder, *T}, side);
  }
  for (int i = 0; i < 4; ++i) {
    const double height = rng.Uniform(0.7, 1.3);
    if (const auto T = find({0.7 * height, 0.7 * height, height})) AddPlant({builder, *T}, height);
  }
}

}  // namespace

SceneModel BuildOffice(const ScenePlan& plan) {
  Rng rng(plan.seed);
  ShapeBuilder builder(plan.materials, Rng(rng.Next()));
  const PathBox room = FitOffice(plan.path_W);
  FloorPlan floor(room.T_WF, 0.5 * room.size.head<2>(), plan.path_W, kClearance);
  AddShell(builder, room);
  SceneModel scene;
  scene.lighting = AddLamps(builder, floor, room);
  AddWallThings(builder, floor);
  for (const double x : {-0.22, 0.22})
    AddIsland(builder, floor, x * room.size.x(), 0);
  AddWallFurniture(builder, floor);
  AddLooseThings(builder, floor);
  scene.mesh = builder.TakeMesh();
  return scene;
}

std::vector<Vector3d> OfficeRoute(std::uint64_t seed) {
  Rng rng(seed + 3);
  // Around one island and then around the other one, in laps.
  const std::vector<Vector2d> points = {{0.1, -2.1},
                                        {4.6, -2.2},
                                        {4.8, 2.1},
                                        {0.1, 2.1},
                                        {-0.1, -2},
                                        {-4.7, -2.1},
                                        {-4.8, 2.2},
                                        {-0.1, 2}};
  std::vector<Vector3d> route_W;
  for (const Vector2d& p : points)
    route_W.emplace_back(p.x(), p.y() + rng.Uniform(-0.15, 0.15), rng.Uniform(1.1, 1.7));
  route_W.push_back(route_W.front());
  return route_W;
}

}  // namespace facet
