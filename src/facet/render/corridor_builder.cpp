// SPDX-License-Identifier: BSD-2-Clause
// A ring of corridors, 72 m around, with rooms inside it. Walls come from a plan of square cells.
#include <array>
#include <cmath>

#include "facet/geometry/so3.h"
#include "facet/render/floor_plan.h"
#include "facet/render/furniture.h"
#include "facet/render/scene_builder.h"

namespace facet {
namespace {

constexpr double kCell = 1.2;  // side of a cell of the plan [m]
constexpr double kHeight = 2.8;
constexpr double kClearance = 0.4;

// '.' is free, '#' solid; the first line is the one with the largest y.
constexpr std::array<const char*, 14> kPlan = {"....................",
                                               "....................",
                                               "..###.########.###..",
                                               "..#......##......#..",
                                               "..#......##......#..",
                                               "..#......##......#..",
                                               "..################..",
                                               "..#......##......#..",
                                               "..#......##......#..",
                                               "..#......##......#..",
                                               "..#......##......#..",
                                               "..###.#######.####..",
                                               "....................",
                                               "...................."};
constexpr int kColumns = 20, kRows = static_cast<int>(kPlan.size());

bool IsFree(int x, int y) {
  if (x < 0 || y < 0 || x >= kColumns || y >= kRows) return false;
  return kPlan[static_cast<std::size_t>(kRows - 1 - y)][x] == '.';
}

/// World from plan: metres from the plan's lower left corner.
SE3 PlanPose(std::uint64_t seed) {
  Rng rng(seed);
  const Quaterniond q = ExpSO3(Vector3d(0, 0, rng.Uniform(0, 2 * std::numbers::pi)));
  return {q, q * Vector3d(-0.5 * kColumns * kCell, -0.5 * kRows * kCell, 0)};
}

/// A straight piece of wall: from `corner_F` along `along_F`, `normal_F` towards the free side.
struct WallRun {
  Vector3d corner_F, along_F, normal_F;
  double length = 0;
};

/// Walls between free cells and those on the side of `normal`, joined into the longest pieces.
void ListRuns(bool is_horizontal, int side, std::vector<WallRun>& runs) {
  const int num_lines = is_horizontal ? kRows : kColumns;
  const int num_cells = is_horizontal ? kColumns : kRows;
  const auto is_wall = [&](int line, int cell) {
    if (cell >= num_cells) return false;
    return is_horizontal ? IsFree(cell, line) && !IsFree(cell, line + side)
                         : IsFree(line, cell) && !IsFree(line + side, cell);
  };
  for (int line = 0; line < num_lines; ++line) {
    for (int cell = 0; cell < num_cells; ++cell) {
      if (!is_wall(line, cell)) continue;
      const int first = cell;
      while (is_wall(line, cell + 1))
        ++cell;
      const double across = kCell * (line + (side > 0 ? 1 : 0)), begin = kCell * first;
      WallRun run;
      run.length = kCell * (cell - first + 1);
      run.corner_F = is_horizontal ? Vector3d(begin, across, 0) : Vector3d(across, begin, 0);
      run.along_F = is_horizontal ? Vector3d::UnitX() : Vector3d::UnitY();
      run.normal_F = is_horizontal ? Vector3d(0, -side, 0) : Vector3d(-side, 0, 0);
      runs.push_back(run);
    }
  }
}

std::vector<WallRun> ListRuns() {
  std::vector<WallRun> runs;
  for (const bool is_horizontal : {true, false}) {
    for (const int side : {-1, 1})
      ListRuns(is_horizontal, side, runs);
  }
  return runs;
}

void AddWalls(ShapeBuilder& builder, const std::vector<WallRun>& runs) {
  const char* const kFinish[] = {"rough_plaster", "plaster", "concrete", "rough_plaster", "brick"};
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const WallRun& run = runs[i];
    const Vector3d up = kHeight * Vector3d::UnitZ();
    Vector3d corner = run.corner_F, along = run.length * run.along_F;
    if (along.cross(up).dot(run.normal_F) < 0) {
      corner += along;
      along = -along;
    }
    builder.AddPatch({"wall", builder.materials().Get(kFinish[i % 5]), 0.12}, corner, along, up);
  }
}

/// Floor and ceiling, one piece for each row of free cells of the same extent.
void AddFloors(ShapeBuilder& builder) {
  const MaterialLibrary& m = builder.materials();
  for (int y = 0; y < kRows; ++y) {
    for (int x = 0; x < kColumns; ++x) {
      if (!IsFree(x, y)) continue;
      const int first = x;
      while (IsFree(x + 1, y))
        ++x;
      const Vector3d corner(kCell * first, kCell * y, 0), u(kCell * (x - first + 1), 0, 0),
          v(0, kCell, 0);
      builder.AddPatch({"floor", m.Get("linoleum"), 0.12}, corner, u, v);
      builder.AddPatch(
          {"ceiling", m.Get("concrete"), 0.2}, corner + v + Vector3d(0, 0, kHeight), u, -v);
    }
  }
}

void AddLamp(ShapeBuilder& builder, const SE3& T_WF, const Vector2d& at, Lighting& lighting) {
  const Vector3d p_F(at.x(), at.y(), kHeight - 0.06);
  builder.Place(T_WF * SE3(Quaterniond::Identity(), p_F));
  builder.AddBox({"lamp", builder.materials().Get("lamp"), 0.5}, {0, 0, 0}, {0.6, 0.6, 0.05});
  lighting.lights.push_back(
      {T_WF * Vector3d(p_F - Vector3d(0, 0, 0.12)), 0.3, builder.rng().Uniform(0.8, 1.8)});
}

Lighting AddLamps(ShapeBuilder& builder, const SE3& T_WF) {
  Lighting lighting;
  lighting.ambient = 0.22;
  for (const double y : {kCell, kCell * (kRows - 1)}) {
    for (double x = 2.4; x < kColumns * kCell; x += 4.8)
      AddLamp(builder, T_WF, {x, y}, lighting);
  }
  for (const double x : {kCell, kCell * (kColumns - 1)}) {
    for (double y = 5.5; y < kRows * kCell - 3; y += 5.5)
      AddLamp(builder, T_WF, {x, y}, lighting);
  }
  for (const double x : {6.0, 16.8}) {
    for (const double y : {6.0, 11.4})
      AddLamp(builder, T_WF, {x, y}, lighting);
  }
  return lighting;
}

/// Places along the walls, at least a metre apart, in the order of the runs.
struct WallPlace {
  const WallRun* run;
  double at;  // along the run
};

SE3 PoseAtWall(const SE3& T_WF, const WallPlace& place, double gap_m, double z) {
  const WallRun& run = *place.run;
  const double yaw = std::atan2(-run.normal_F.x(), run.normal_F.y());  // +y to the normal
  const Vector3d p_F = run.corner_F + place.at * run.along_F + gap_m * run.normal_F;
  return T_WF * SE3(ExpSO3(Vector3d(0, 0, yaw)), p_F + Vector3d(0, 0, z));
}

/// Posters, doors, shelves, boxes and boards along the walls.
void Furnish(ShapeBuilder& builder,
             const SE3& T_WF,
             const std::vector<WallRun>& runs,
             std::span<const Vector3d> path_W) {
  Rng& rng = builder.rng();
  const MaterialLibrary& m = builder.materials();
  const auto is_clear = [&](const SE3& T_WO, const Vector3d& size) {
    return IsClearOfPath(path_W, T_WO, size, kClearance);
  };
  for (const WallRun& run : runs) {
    for (double at = rng.Uniform(0.7, 1.4); at < run.length - 0.7; at += rng.Uniform(1.3, 2.6)) {
      const WallPlace place{&run, at};
      const double share = rng.Uniform();
      if (share < 0.45) {
        const double width = rng.Uniform(0.4, 1);
        const Vector2d size(width, width * rng.Uniform(0.7, 1.3));
        const double z = rng.Uniform(1.2, 1.9);
        AddPanel(
            {builder, PoseAtWall(T_WF, place, 0.006, z)}, "poster", size, m.RandomPicture(rng));
      } else if (share < 0.6) {
        const int material = m.Get(rng.Index(2) ? "wood" : "boards");
        AddPanel({builder, PoseAtWall(T_WF, place, 0.02, 1.02)}, "door", {0.95, 2.03}, material);
      } else if (share < 0.75) {
        const Vector3d size(0.9, 0.3, rng.Uniform(1, 1.9));
        const SE3 T_WO = PoseAtWall(T_WF, place, 0.02 + size.y() / 2, 0);
        if (is_clear(T_WO, size)) AddShelf({builder, T_WO}, size);
      } else if (share < 0.9) {
        const SE3 T_WO = PoseAtWall(T_WF, place, 0.3, 0);
        if (is_clear(T_WO, {0.5, 0.5, 1})) AddBoxStack({builder, T_WO}, 0.4);
      } else {
        const double lean = rng.Uniform(5, 15) * std::numbers::pi / 180, height = 1.6;
        const SE3 T_WO = PoseAtWall(T_WF, place, height * std::sin(lean) + 0.05, 0.001);
        if (is_clear(T_WO, {1, 0.5, height}))
          AddLeaningBoard({builder, T_WO}, {0.9, height}, m.RandomPicture(rng), lean);
      }
    }
  }
  for (const double x : {5.4, 16.2}) {
    const SE3 T_WO = T_WF * SE3(Quaterniond::Identity(), {x + 1.2, x < 10 ? 6.0 : 11.4, 0});
    if (is_clear(T_WO, {1.4, 0.7, 1.1})) AddTable({builder, T_WO}, {1.4, 0.7, 0.74});
  }
  for (const double y : {0.3, kCell * kRows - 0.3}) {
    const SE3 T_FO(Quaterniond::Identity(), {0.02, y, kHeight - 0.2});
    AddPipe({builder, T_WF * T_FO}, 0.07, kColumns * kCell - 0.04);
  }
}

}  // namespace

SceneModel BuildCorridor(const ScenePlan& plan) {
  const SE3 T_WF = PlanPose(plan.seed);
  ShapeBuilder builder(plan.materials, Rng(plan.seed + 1));
  const std::vector<WallRun> runs = ListRuns();
  builder.Place(T_WF);
  AddWalls(builder, runs);
  AddFloors(builder);
  SceneModel scene;
  scene.lighting = AddLamps(builder, T_WF);
  Furnish(builder, T_WF, runs, plan.path_W);
  scene.mesh = builder.TakeMesh();
  return scene;
}

std::vector<Vector3d> CorridorRoute(std::uint64_t seed) {
  Rng rng(seed + 2);
  const SE3 T_WF = PlanPose(seed);
  const double right = kCell * (kColumns - 1), top = kCell * (kRows - 1), door = 13.5 * kCell;
  // Into the room behind the door, around it, out again, and then around the ring in laps.
  const std::vector<Vector2d> points = {{3, kCell},
                                        {door, kCell},
                                        {door, 5.4},
                                        {14.7, 6.6},
                                        {18.6, 7.0},
                                        {door, 5.4},
                                        {door, kCell},
                                        {right, kCell},
                                        {right, top},
                                        {kCell, top},
                                        {kCell, kCell},
                                        {9, kCell}};
  std::vector<Vector3d> route_W;
  for (const Vector2d& p : points)
    route_W.push_back(T_WF * Vector3d(p.x(), p.y(), rng.Uniform(1.3, 1.6)));
  constexpr std::size_t kFirstOfLap = 6;
  route_W.push_back(route_W[kFirstOfLap]);
  return route_W;
}

}  // namespace facet
