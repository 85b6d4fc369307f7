// SPDX-License-Identifier: BSD-2-Clause
// A furnished room, the size of a motion-capture room or larger if the path needs it.
#include <algorithm>
#include <cmath>
#include <limits>

#include "facet/geometry/so3.h"
#include "facet/render/floor_plan.h"
#include "facet/render/furniture.h"
#include "facet/render/path_box.h"
#include "facet/render/scene_builder.h"

namespace facet {
namespace {

constexpr double kClearance = 0.45;  // between the path and what stands in the room

PathBox FitRoom(std::span<const Vector3d> path_W, Rng& rng) {
  PathBox room = BoundPath(path_W, rng.Uniform(0, std::numbers::pi / 2));
  room.size = Vector3d(std::max(8.0, room.size.x() + 2.4),
                       std::max(8.0, room.size.y() + 2.4),
                       std::max(4.0, room.size.z() + 0.8));
  return room;
}

void AddShell(ShapeBuilder& builder, const PathBox& room) {
  const MaterialLibrary& m = builder.materials();
  const Vector3d half = 0.5 * room.size;
  constexpr double kCell = 0.1;
  builder.Place(room.T_WF);
  builder.AddPatch({"floor", m.Get("linoleum"), kCell},
                   {-half.x(), -half.y(), 0},
                   {room.size.x(), 0, 0},
                   {0, room.size.y(), 0});
  builder.AddPatch({"ceiling", m.Get("concrete"), kCell},
                   {-half.x(), half.y(), room.size.z()},
                   {room.size.x(), 0, 0},
                   {0, -room.size.y(), 0});
  const char* const kFinish[] = {"rough_plaster", "plaster", "brick", "rough_plaster"};
  for (int wall = 0; wall < 4; ++wall) {
    const double width = room.size(wall % 2), depth = half(1 - wall % 2);
    builder.Place(room.T_WF *
                  SE3(ExpSO3(Vector3d(0, 0, std::numbers::pi / 2 * wall)), Vector3d::Zero()));
    builder.AddPatch({"wall", m.Get(kFinish[wall]), kCell},
                     {width / 2, -depth, 0},
                     {-width, 0, 0},
                     {0, 0, room.size.z()});
  }
}

/// Lamps under the ceiling and a window; their panels glow.
Lighting AddLamps(ShapeBuilder& builder, FloorPlan& plan, const PathBox& room) {
  Lighting lighting;
  lighting.ambient = 0.4;
  Rng& rng = builder.rng();
  for (const double x : {-0.25, 0.25}) {
    const double y = rng.Uniform(-0.25, 0.25);
    const Vector3d p_F(x * room.size.x(), y * room.size.y(), room.size.z() - 0.12);
    builder.Place(room.T_WF * SE3(Quaterniond::Identity(), p_F));
    builder.AddBox({"lamp", builder.materials().Get("lamp"), 0.5}, {0, 0, 0}, {1.2, 0.15, 0.06});
    lighting.lights.push_back(
        {room.T_WF * Vector3d(p_F - Vector3d(0, 0, 0.15)), 0.4, rng.Uniform(2, 4.5)});
  }
  const Vector2d window(1.4, 1.2);
  if (const auto T_WO = plan.FindOnWall(window, 1.9, room.size.z() - 1, rng)) {
    AddPanel({builder, *T_WO}, "window", window, builder.materials().Get("lamp"));
    lighting.lights.push_back({*T_WO * Vector3d(0, 0.3, 0), 0.5, rng.Uniform(2, 4)});
  }
  return lighting;
}

void AddWallThings(ShapeBuilder& builder, FloorPlan& plan, const PathBox& room) {
  Rng& rng = builder.rng();
  const double perimeter = 2 * (room.size.x() + room.size.y());
  for (int i = static_cast<int>(0.3 * perimeter); i > 0; --i) {
    const double width = rng.Uniform(0.4, 1.4);
    const Vector2d size(width, width * rng.Uniform(0.6, 1.4));
    const auto T_WO = plan.FindOnWall(size, 1.2, std::max(1.3, room.size.z() - 0.9), rng);
    if (T_WO) AddPanel({builder, *T_WO}, "poster", size, builder.materials().RandomPicture(rng));
  }
  for (int i = 0; i < 3; ++i) {
    const double radius = rng.Uniform(0.04, 0.11);
    const Vector3d p_F(-room.size.x() / 2 + 0.02,
                       rng.Uniform(-0.45, 0.45) * room.size.y(),
                       room.size.z() - 0.3 - radius);
    AddPipe({builder, room.T_WF * SE3(Quaterniond::Identity(), p_F)}, radius, room.size.x() - 0.04);
  }
}

/// Tape and mats on the floor: flat, so nothing can be in the way.
void AddFloorMarks(ShapeBuilder& builder, const PathBox& room) {
  Rng& rng = builder.rng();
  for (int i = 0; i < 7; ++i) {
    const double x = 0.38 * room.size.x() * rng.Uniform(-1, 1);
    const double y = 0.38 * room.size.y() * rng.Uniform(-1, 1);
    const SE3 T_FO(ExpSO3(Vector3d(0, 0, rng.Uniform(0, 2 * std::numbers::pi))),
                   {x, y, 0.002 + 0.0015 * i});
    const Spot spot{builder, room.T_WF * T_FO};
    const MaterialLibrary& m = builder.materials();
    if (i < 3) {
      AddMat(spot, "tape", {rng.Uniform(0.08, 0.15), rng.Uniform(1, 2.2)}, m.Get("tape"));
    } else if (i < 5) {
      AddMat(spot, "sheet", {0.5, 0.7}, m.RandomPicture(rng));
    } else {
      AddMat(spot, "carpet", {rng.Uniform(1, 1.6), rng.Uniform(1.4, 2.2)}, m.Get("carpet"));
    }
  }
}

/// What somebody with a camera in the hand looks at: slatted benches with netted heaps on them, and
/// rails, at the height of the lowest of these points. As many as there is room for.
void AddNearThings(ShapeBuilder& builder, FloorPlan& plan, std::span<const Vector3d> near_W) {
  Rng& rng = builder.rng();
  double height = std::numeric_limits<double>::infinity();
  for (const Vector3d& p_W : near_W)
    height = std::min(height, (plan.T_WF().Inverse() * p_W).z());
  height = std::max(height, 0.4);
  for (int i = 0; i < 6; ++i) {
    const double heap = rng.Uniform(0.6, 0.9);
    const double width = rng.Uniform(1.0, 1.3), below = rng.Uniform(0.3, 0.5);
    const Vector3d bench(width, 0.8, std::max(0.3, height - below));
    const auto T_WO = plan.FindNear({{bench.x(), bench.y(), bench.z() + 0.75 * heap}}, near_W, rng);
    if (!T_WO) continue;
    AddBench({builder, *T_WO}, bench);
    const SE3 T_OH(Quaterniond::Identity(), {rng.Uniform(-0.2, 0.2), 0, bench.z()});
    AddNettedHeap({builder, *T_WO * T_OH}, heap);
  }
  for (int i = 0; i < 3; ++i) {
    const double width = rng.Uniform(1.0, 1.5);
    if (const auto T_WO = plan.FindNear({{width, 0.15, height + 0.2}}, near_W, rng))
      AddRailing({builder, *T_WO}, width, height + 0.15);
  }
}

void AddFurniture(ShapeBuilder& builder, FloorPlan& plan) {
  Rng& rng = builder.rng();
  const MaterialLibrary& m = builder.materials();
  const auto find = [&](const Vector3d& size, bool at_wall, double gap_m = 0.02) {
    return plan.Find({size, at_wall, gap_m}, rng);
  };
  for (int i = 0; i < 3; ++i) {
    const Vector3d shelf(rng.Uniform(0.8, 1.4), 0.34, rng.Uniform(1.4, 2.1));
    if (const auto T = find(shelf, true)) AddShelf({builder, *T}, shelf);
  }
  for (int i = 0; i < 5; ++i) {
    const double lean = rng.Uniform(5, 15) * std::numbers::pi / 180;
    const Vector2d board(rng.Uniform(0.9, 1.5), rng.Uniform(1.4, 2.2));
    const double depth = board.y() * std::sin(lean) + 0.05;
    const int material = i % 2 ? m.RandomPicture(rng) : m.Get(i % 4 ? "boards" : "fabric");
    // The foot of the board is in front of the place's middle, its head near the wall.
    if (const auto T = find({board.x(), depth, board.y()}, true)) {
      const SE3 foot(Quaterniond::Identity(), {0, depth / 2, 0.001});
      AddLeaningBoard({builder, *T * foot}, board, material, lean);
    }
  }
  for (int i = 0; i < 3; ++i) {
    const Vector3d table(rng.Uniform(1.0, 1.7), rng.Uniform(0.6, 0.8), rng.Uniform(0.7, 0.78));
    const Vector3d space(table.x(), table.y(), table.z() + 0.4);
    if (const auto T = find(space, i > 0)) AddTable({builder, *T}, table);
  }
  for (int i = 0; i < 5; ++i) {
    if (const auto T = find({0.5, 0.5, 0.95}, false)) AddChair({builder, *T});
  }
  for (int i = 0; i < 7; ++i) {
    const double side = rng.Uniform(0.35, 0.7);
    if (const auto T = find({1.2 * side, 1.2 * side, 2 * side}, i > 3, 0.1))
      AddBoxStack({builder, *T}, side);
  }
  for (int i = 0; i < 3; ++i) {
    const double radius = rng.Uniform(0.15, 0.3), height = rng.Uniform(0.6, 1.3);
    const auto T = find({2 * radius, 2 * radius, height}, false);
    if (!T) continue;
    builder.Place(*T);
    builder.AddCylinder({"barrel", m.Get(i ? "stone" : "metal"), 0.1}, radius, height);
  }
  for (int i = 0; i < 4; ++i) {
    const double radius = rng.Uniform(0.2, 0.4);
    const auto T = find({2.6 * radius, 2.6 * radius, 2.6 * radius}, false);
    if (!T) continue;
    builder.Place(*T * SE3(Quaterniond::Identity(), {0, 0, 0.95 * radius}));
    if (i < 2) {
      builder.AddSphere({"ball", m.RandomPicture(rng), 0.1}, radius);
    } else {
      builder.AddBlob({"rock", m.Get("stone"), 0.06}, radius, 0.18);
    }
  }
  for (int i = 0; i < 3; ++i) {
    const double size = rng.Uniform(0.7, 1.1);
    if (const auto T = find({size, size, 0.75 * size}, false)) AddNettedHeap({builder, *T}, size);
  }
  for (int i = 0; i < 3; ++i) {
    const double width = rng.Uniform(1.2, 2);
    if (const auto T = find({width, 0.15, 1.15}, false)) AddRailing({builder, *T}, width, 1.1);
  }
  for (int i = 0; i < 4; ++i) {
    const double height = rng.Uniform(0.7, 1.4);
    if (const auto T = find({0.7 * height, 0.7 * height, height}, false))
      AddPlant({builder, *T}, height);
  }
}

}  // namespace

SceneModel BuildRoom(const ScenePlan& plan) {
  Rng rng(plan.seed);
  Rng shape_rng(rng.Next()), content_rng(rng.Next());
  const PathBox room = FitRoom(plan.path_W, shape_rng);
  FloorPlan floor(room.T_WF, 0.5 * room.size.head<2>(), plan.path_W, kClearance);
  ShapeBuilder builder(plan.materials, content_rng);
  AddShell(builder, room);
  SceneModel scene;
  scene.lighting = AddLamps(builder, floor, room);
  AddWallThings(builder, floor, room);
  AddFloorMarks(builder, room);
  if (!plan.near_W.empty()) AddNearThings(builder, floor, plan.near_W);
  AddFurniture(builder, floor);
  scene.mesh = builder.TakeMesh();
  return scene;
}

std::vector<Vector3d> RoomRoute(std::uint64_t seed) {
  Rng rng(seed);
  std::vector<Vector3d> route_W;
  while (route_W.size() < 40) {
    const double x = rng.Uniform(-2.3, 2.3), y = rng.Uniform(-2.3, 2.3);
    const Vector3d p_W(x, y, rng.Uniform(0.9, 2.2));
    const double step = route_W.empty() ? 2 : (p_W - route_W.back()).norm();
    if (step > 1.5 && step < 3.5) route_W.push_back(p_W);
  }
  return route_W;
}

}  // namespace facet
