// SPDX-License-Identifier: BSD-2-Clause
#include "facet/render/furniture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "facet/geometry/so3.h"

namespace facet {

void PlaceInside(const Spot& spot, const Vector3d& p_O, double yaw_rad) {
  spot.builder.Place(spot.T_WO * SE3(ExpSO3(Vector3d(0, 0, yaw_rad)), p_O));
}

int MaterialOf(const Spot& spot, const char* name) {
  return spot.builder.materials().Get(name);
}

namespace {

/// Cardboard, a picture, wood, ...: what small things are made of.
int SmallThingMaterial(const Spot& spot) {
  Rng& rng = spot.builder.rng();
  switch (rng.Index(5)) {
    case 0:
      return MaterialOf(spot, "cardboard");
    case 1:
      return MaterialOf(spot, "stone");
    case 2:
      return MaterialOf(spot, "boards");
    default:
      return spot.builder.materials().RandomPicture(rng);
  }
}

/// A thing on a surface of the given width and depth, at most `max_height` high.
void AddSmallThing(const Spot& spot, const Vector3d& p_O, double size, double max_height) {
  Rng& rng = spot.builder.rng();
  const double height = std::min(max_height, size * rng.Uniform(0.6, 1.6));
  PlaceInside(spot, p_O, rng.Uniform(-0.4, 0.4));
  const ShapeBuilder::Finish finish{"thing", SmallThingMaterial(spot), 0.1};
  const int kind = rng.Index(6);
  if (kind == 0) {
    spot.builder.AddCylinder(finish, 0.4 * std::min(size, height), height);
  } else if (kind == 1) {
    const double radius = 0.5 * std::min(size, height);
    PlaceInside(spot, p_O + Vector3d(0, 0, radius));
    spot.builder.AddSphere(finish, radius);
  } else {
    spot.builder.AddBox(finish, {0, 0, height / 2}, {size, size * rng.Uniform(0.5, 1.0), height});
  }
}

}  // namespace

void AddTable(const Spot& spot, const Vector3d& size) {
  constexpr double kTop = 0.035, kLeg = 0.05;
  Rng& rng = spot.builder.rng();
  const int wood = MaterialOf(spot, "wood");
  PlaceInside(spot, Vector3d::Zero());
  spot.builder.AddBox({"table", wood}, {0, 0, size.z() - kTop / 2}, {size.x(), size.y(), kTop});
  for (const double x : {-1.0, 1.0}) {
    for (const double y : {-1.0, 1.0}) {
      spot.builder.AddBox(
          {"leg", wood},
          {x * (size.x() / 2 - kLeg), y * (size.y() / 2 - kLeg), (size.z() - kTop) / 2},
          {kLeg, kLeg, size.z() - kTop});
    }
  }
  const int num_things = std::max(2, static_cast<int>(size.x() / 0.3));
  for (int i = 0; i < num_things; ++i) {
    const double x = size.x() * ((i + 0.5) / num_things - 0.5);
    const double y = 0.5 * (size.y() - 0.3) * rng.Uniform(-1, 1);
    AddSmallThing(spot, {x, y, size.z()}, rng.Uniform(0.12, 0.26), 0.4);
  }
}

void AddDesk(const Spot& spot, const Vector3d& size) {
  constexpr double kTop = 0.03;
  Rng& rng = spot.builder.rng();
  const MaterialLibrary& m = spot.builder.materials();
  PlaceInside(spot, Vector3d::Zero());
  spot.builder.AddBox(
      {"table", m.Get("wood")}, {0, 0, size.z() - kTop / 2}, {size.x(), size.y(), kTop});
  for (const double x : {-1.0, 1.0}) {
    spot.builder.AddBox({"desk", m.Get("boards")},
                        {x * (size.x() / 2 - 0.015), 0, (size.z() - kTop) / 2},
                        {0.025, size.y() - 0.06, size.z() - kTop});
  }
  const double turn = rng.Uniform(-0.25, 0.25), width = rng.Uniform(0.5, 0.65);
  const double at = rng.Uniform(-0.2, 0.2);
  PlaceInside(spot, {at, -0.2, size.z()}, turn);
  const int dark = m.Get("dark");
  spot.builder.AddBox({"stand", dark}, {0, -0.02, 0.006}, {0.25, 0.2, 0.012});
  spot.builder.AddBox({"stand", dark}, {0, -0.04, 0.09}, {0.06, 0.03, 0.16});
  spot.builder.AddBox({"screen", dark}, {0, 0, 0.28}, {width, 0.04, 0.36});
  spot.builder.AddPatch({"screen", m.Get("screen")},
                        {width / 2 - 0.01, 0.022, 0.11},
                        {-width + 0.02, 0, 0},
                        {0, 0, 0.34});
  PlaceInside(spot, {at, 0.12, size.z()}, rng.Uniform(-0.2, 0.2));
  spot.builder.AddBox({"keyboard", m.Get("dark")}, {0, 0, 0.01}, {0.42, 0.14, 0.02});
  for (const double x : {-0.6, 0.58}) {
    const Vector3d p_O(x, rng.Uniform(-0.15, 0.2), size.z());
    if (rng.Index(3) == 0) {
      AddSmallThing(spot, p_O, rng.Uniform(0.1, 0.2), 0.35);
    } else {
      PlaceInside(spot, p_O, rng.Uniform(-0.5, 0.5));
      const double pile = rng.Uniform(0.01, 0.08);
      spot.builder.AddBox({"paper", m.RandomPicture(rng)}, {0, 0, pile / 2}, {0.21, 0.3, pile});
    }
  }
}

void AddDrawingTable(const Spot& spot, double slope_rad) {
  constexpr double kWidth = 1.1, kDepth = 0.75, kHeight = 0.9, kBoard = 0.025;
  const MaterialLibrary& m = spot.builder.materials();
  // Turned about x: its back, towards -y, comes up.
  const SE3 T_OB(ExpSO3(Vector3d(-slope_rad, 0, 0)), {0, 0, kHeight});
  spot.builder.Place(spot.T_WO * T_OB);
  spot.builder.AddBox({"board", m.Get("boards")}, Vector3d::Zero(), {kWidth, kDepth, kBoard});
  spot.builder.AddPatch({"drawing", m.RandomPicture(spot.builder.rng())},
                        {-0.4 * kWidth, -0.4 * kDepth, kBoard / 2 + 0.002},
                        {0.8 * kWidth, 0, 0},
                        {0, 0.8 * kDepth, 0});
  PlaceInside(spot, Vector3d::Zero());
  for (const double x : {-0.4, 0.4}) {
    const double z = kHeight - kBoard;
    spot.builder.AddBox({"leg", m.Get("wood")}, {x * kWidth, 0, z / 2}, {0.06, 0.1, z});
    spot.builder.AddBox({"leg", m.Get("wood")}, {x * kWidth, 0, 0.03}, {0.06, 0.6, 0.06});
  }
}

void AddRamp(const Spot& spot, const Vector3d& size) {
  PlaceInside(spot, Vector3d::Zero());
  const ShapeBuilder::Finish finish{"ramp", MaterialOf(spot, "boards")};
  const double x = size.x() / 2, y = size.y() / 2, z = size.z();
  spot.builder.AddPatch(finish, {-x, -y, 0}, {size.x(), 0, z}, {0, size.y(), 0});
  spot.builder.AddPatch(finish, {x, -y, 0}, {0, size.y(), 0}, {0, 0, z});
  spot.builder.AddTriangles(finish,
                            {{-x, -y, 0}, {x, -y, 0}, {x, -y, z}, {-x, y, 0}, {x, y, z}, {x, y, 0}},
                            {{0, 1, 2}, {3, 4, 5}});
}

void AddBench(const Spot& spot, const Vector3d& size) {
  constexpr double kBoard = 0.022, kBeam = 0.09, kTurn_rad = 0.01;
  Rng& rng = spot.builder.rng();
  const ShapeBuilder::Finish boards{"bench", MaterialOf(spot, "boards")};
  const double top = size.z() - kBoard;
  for (double y = -size.y() / 2; y < size.y() / 2 - 0.05;) {
    const double width = std::min(rng.Uniform(0.09, 0.15), size.y() / 2 - y);
    PlaceInside(spot, {0, y + width / 2, top + kBoard / 2}, rng.Uniform(-kTurn_rad, kTurn_rad));
    spot.builder.AddBox(boards, Vector3d::Zero(), {size.x(), width, kBoard});
    y += width + rng.Uniform(0.02, 0.06);
  }
  PlaceInside(spot, Vector3d::Zero());
  for (const double x : {-0.45, 0.0, 0.45}) {
    spot.builder.AddBox(boards, {x * size.x(), 0, top - kBeam / 2}, {kBeam, size.y(), kBeam});
    spot.builder.AddBox(boards, {x * size.x(), 0, (top - kBeam) / 2}, {kBeam, kBeam, top - kBeam});
  }
}

void AddShelf(const Spot& spot, const Vector3d& size) {
  constexpr double kBoard = 0.025;
  Rng& rng = spot.builder.rng();
  const ShapeBuilder::Finish wood{"shelf", MaterialOf(spot, rng.Index(2) ? "wood" : "dark")};
  PlaceInside(spot, Vector3d::Zero());
  for (const double x : {-1.0, 1.0}) {
    spot.builder.AddBox(
        wood, {x * (size.x() - kBoard) / 2, 0, size.z() / 2}, {kBoard, size.y(), size.z()});
  }
  const int num_boards = std::max(2, static_cast<int>(std::lround(size.z() / 0.42)));
  const double inner = size.x() - 2 * kBoard;
  for (int i = 0; i <= num_boards; ++i) {
    const double z = 0.05 + (size.z() - 0.1) * i / num_boards;
    PlaceInside(spot, Vector3d::Zero());
    spot.builder.AddBox(wood, {0, 0, z}, {inner, size.y() - 0.01, kBoard});
    if (i == num_boards) break;
    const double room = (size.z() - 0.1) / num_boards - 2 * kBoard;
    for (double x = -inner / 2 + 0.1; x < inner / 2 - 0.1;) {
      const double width = rng.Uniform(0.06, 0.24);
      if (rng.Uniform() < 0.8) {
        AddSmallThing(spot,
                      {x + width / 2, rng.Uniform(-0.05, 0.05), z + kBoard / 2},
                      std::min(width, size.y() - 0.12),
                      room);
      }
      x += width + rng.Uniform(0.01, 0.08);
    }
  }
}

void AddChair(const Spot& spot) {
  constexpr double kSeat = 0.45, kWidth = 0.42, kLeg = 0.035;
  PlaceInside(spot, Vector3d::Zero());
  const int wood = MaterialOf(spot, "wood");
  spot.builder.AddBox({"chair", MaterialOf(spot, "fabric")}, {0, 0, kSeat}, {kWidth, kWidth, 0.05});
  spot.builder.AddBox({"chair", wood}, {0, -kWidth / 2, 0.75}, {kWidth, 0.03, 0.3});
  for (const double x : {-1.0, 1.0}) {
    for (const double y : {-1.0, 1.0}) {
      const double height = y < 0 ? 0.88 : kSeat - 0.025;
      spot.builder.AddBox({"leg", wood},
                          {x * (kWidth / 2 - kLeg), y * (kWidth / 2 - kLeg), height / 2},
                          {kLeg, kLeg, height});
    }
  }
}

void AddBoxStack(const Spot& spot, double side) {
  Rng& rng = spot.builder.rng();
  double z = 0;
  for (int i = rng.Index(3) + 1; i > 0; --i) {
    const Vector3d size(
        side * rng.Uniform(0.8, 1.1), side * rng.Uniform(0.6, 1), side * rng.Uniform(0.5, 0.9));
    PlaceInside(spot, {0, 0, z}, rng.Uniform(-0.3, 0.3));
    spot.builder.AddBox({"box", MaterialOf(spot, "cardboard")}, {0, 0, size.z() / 2}, size);
    z += size.z();
    side *= 0.8;
  }
}

void AddLeaningBoard(const Spot& spot, const Vector2d& size, int material, double lean_rad) {
  constexpr double kThickness = 0.03;
  spot.builder.Place(spot.T_WO * SE3(ExpSO3(Vector3d(lean_rad, 0, 0)), Vector3d::Zero()));
  spot.builder.AddBox(
      {"board", material}, {0, -kThickness / 2, size.y() / 2}, {size.x(), kThickness, size.y()});
}

void AddNettedHeap(const Spot& spot, double size) {
  Rng& rng = spot.builder.rng();
  const double radius = 0.5 * size;
  PlaceInside(spot, {0, 0, 0.35 * radius});
  spot.builder.AddBlob({"heap", MaterialOf(spot, "fabric"), 0.06}, 0.62 * radius, 0.15);
  // Strands over a hood with folds; each strand is a narrow ribbon.
  const double fold = rng.Uniform(0, 6), height = 0.75 * size;
  const auto hood = [&](double x, double y) {
    const double r = std::hypot(x, y) / radius, angle = std::atan2(y, x);
    const double drop = height * std::max(0.0, 1 - r * r);
    return Vector3d(x, y, 0.01 + drop * (1 + 0.12 * std::sin(5 * angle + fold) * r));
  };
  constexpr double kPitch = 0.055, kStrand = 0.007;
  const ShapeBuilder::Finish finish{"net", MaterialOf(spot, "plaster"), 0.05, true};
  PlaceInside(spot, Vector3d::Zero());
  for (double at = -radius + kPitch; at < radius - kPitch / 2; at += kPitch) {
    const double reach = std::sqrt(radius * radius - at * at);
    const int cells = std::max(4, static_cast<int>(2 * reach / 0.05));
    for (const bool is_along_x : {true, false}) {
      spot.builder.AddCurved(finish, {cells, 1, 2 * reach, kStrand}, [&](double s, double t) {
        const double along = (2 * s - 1) * reach, across = at + (t - 0.5) * kStrand;
        return is_along_x ? hood(along, across) : hood(across, -along);
      });
    }
  }
}

void AddRailing(const Spot& spot, double width, double height) {
  constexpr double kBar = 0.012, kPost = 0.02;
  const ShapeBuilder::Finish finish{"rail", MaterialOf(spot, "metal"), 0.15};
  for (const double share : {-0.5, 0.0, 0.5}) {
    PlaceInside(spot, {share * width, 0, 0});
    spot.builder.AddCylinder(finish, kPost, height);
  }
  for (double z = 0.25 * height; z <= height; z += 0.25 * height) {
    const SE3 along_x(ExpSO3(Vector3d(0, std::numbers::pi / 2, 0)), {-width / 2, 0, z});
    spot.builder.Place(spot.T_WO * along_x);
    spot.builder.AddCylinder(finish, kBar, width);
  }
}

void AddPlant(const Spot& spot, double height) {
  const double pot = 0.3 * height;
  PlaceInside(spot, Vector3d::Zero());
  spot.builder.AddCylinder({"pot", MaterialOf(spot, "stone"), 0.08}, 0.16 * height, pot);
  PlaceInside(spot, {0, 0, 0.65 * height});
  spot.builder.AddFoliage({"plant", MaterialOf(spot, "leaf")}, 0.35 * height, 220);
}

void AddPanel(const Spot& spot, const std::string& label, const Vector2d& size, int material) {
  PlaceInside(spot, Vector3d::Zero());
  spot.builder.AddPatch(
      {label, material}, {size.x() / 2, 0, -size.y() / 2}, {-size.x(), 0, 0}, {0, 0, size.y()});
}

void AddMat(const Spot& spot, const std::string& label, const Vector2d& size, int material) {
  PlaceInside(spot, Vector3d::Zero());
  spot.builder.AddPatch(
      {label, material}, {-size.x() / 2, -size.y() / 2, 0}, {size.x(), 0, 0}, {0, size.y(), 0});
}

void AddPipe(const Spot& spot, double radius, double length) {
  spot.builder.Place(spot.T_WO *
                     SE3(ExpSO3(Vector3d(0, std::numbers::pi / 2, 0)), Vector3d::Zero()));
  spot.builder.AddCylinder({"pipe", MaterialOf(spot, "metal"), 0.2}, radius, length);
}

}  // namespace facet
