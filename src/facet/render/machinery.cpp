// SPDX-License-Identifier: BSD-2-Clause
#include "facet/render/machinery.h"

#include <algorithm>
#include <cmath>

#include "facet/geometry/so3.h"

namespace facet {
namespace {

const char* const kCovers[] = {"machine", "dark_machine", "machine", "metal"};

int Cover(const Spot& spot) {
  return MaterialOf(spot, kCovers[spot.builder.rng().Index(4)]);
}

/// Along +x (axis 0), +y or +z from a point.
void AddTube(const Spot& spot, const Vector3d& from_O, int axis, double radius, double length) {
  const Vector3d turn = axis == 0   ? Vector3d(0, std::numbers::pi / 2, 0)
                        : axis == 1 ? Vector3d(-std::numbers::pi / 2, 0, 0)
                                    : Vector3d(0, 0, 0);
  spot.builder.Place(spot.T_WO * SE3(ExpSO3(turn), from_O));
  spot.builder.AddCylinder({"pipe", MaterialOf(spot, "metal"), 0.15}, radius, length);
}

/// A desk on the front of a machine that faces up by 35 degrees.
void AddControlPanel(const Spot& spot, const Vector3d& p_O) {
  constexpr double kSlope = 0.6;
  PlaceInside(spot, p_O);
  spot.builder.AddBox({"console", MaterialOf(spot, "dark_machine")}, {0, 0, 0.45}, {0.5, 0.3, 0.9});
  const SE3 T_OP(ExpSO3(Vector3d(-kSlope, 0, 0)), p_O + Vector3d(0, 0, 0.98));
  spot.builder.Place(spot.T_WO * T_OP);
  spot.builder.AddBox({"console", MaterialOf(spot, "machine")}, {0, 0, 0}, {0.5, 0.36, 0.08});
  spot.builder.AddPatch(
      {"console", MaterialOf(spot, "screen")}, {-0.2, -0.14, 0.042}, {0.4, 0, 0}, {0, 0.28, 0});
}

/// A tank on legs or a motor that lies.
void AddRoundPart(const Spot& spot, const Vector3d& p_O, const Vector3d& size) {
  Rng& rng = spot.builder.rng();
  const double radius = 0.45 * std::min(size.x(), size.y());
  PlaceInside(spot, p_O);
  if (rng.Index(2) == 0) {
    spot.builder.AddCylinder({"tank", Cover(spot), 0.15}, radius, 0.9 * size.z());
    PlaceInside(spot, p_O + Vector3d(0, 0, 0.9 * size.z()));
    spot.builder.AddCylinder(
        {"tank", MaterialOf(spot, "metal"), 0.1}, 0.3 * radius, 0.1 * size.z());
    return;
  }
  spot.builder.AddBox({"base", MaterialOf(spot, "dark_machine")},
                      {0, 0, 0.15},
                      {0.9 * size.x(), 0.9 * size.y(), 0.3});
  AddTube(spot, p_O + Vector3d(-0.45 * size.x(), 0, 0.3 + radius), 0, radius, 0.7 * size.x());
  AddTube(spot, p_O + Vector3d(0.2 * size.x(), 0, 0.3 + radius), 0, 0.5 * radius, 0.25 * size.x());
}

void AddCrate(const Spot& spot, const Vector3d& p_O, const Vector3d& size, double yaw) {
  Rng& rng = spot.builder.rng();
  PlaceInside(spot, p_O, yaw);
  const char* const kMaterials[] = {"boards", "cardboard", "cardboard", "wood", "fabric"};
  spot.builder.AddBox(
      {"crate", MaterialOf(spot, kMaterials[rng.Index(5)])}, {0, 0, size.z() / 2}, size);
}

}  // namespace

void AddMachine(const Spot& spot, const Vector3d& size) {
  Rng& rng = spot.builder.rng();
  const double base = rng.Uniform(0.12, 0.25);
  PlaceInside(spot, Vector3d::Zero());
  spot.builder.AddBox(
      {"base", MaterialOf(spot, "concrete")}, {0, 0, base / 2}, {size.x(), size.y(), base});
  const int num_housings = std::max(1, static_cast<int>(size.x() / 1.1));
  const double width = size.x() / num_housings;
  for (int i = 0; i < num_housings; ++i) {
    const double x = (i + 0.5) * width - size.x() / 2;
    const Vector3d housing(width * rng.Uniform(0.75, 0.95),
                           0.8 * size.y() * rng.Uniform(0.7, 1),
                           (size.z() - base) * rng.Uniform(0.5, 1));
    if (num_housings > 1 && rng.Index(4) == 0) {
      AddRoundPart(spot, {x, 0, base}, housing);
      continue;
    }
    PlaceInside(spot, {x, -0.08 * size.y(), base});
    spot.builder.AddBox({"machine", Cover(spot)}, {0, 0, housing.z() / 2}, housing);
    // A door or a cover that juts out of the front, and a box on top.
    const Vector3d door(0.6 * housing.x(), 0.05, 0.55 * housing.z());
    spot.builder.AddBox(
        {"cover", Cover(spot)}, {0, housing.y() / 2 + 0.025, 0.5 * housing.z()}, door);
    if (housing.z() < 0.8 * (size.z() - base)) {
      spot.builder.AddBox({"box", Cover(spot)},
                          {0.1 * housing.x(), 0, housing.z() + 0.1},
                          {0.5 * housing.x(), 0.5 * housing.y(), 0.2});
    }
  }
  AddControlPanel(spot, {0.3 * size.x() * rng.Uniform(-1, 1), 0.5 * size.y() - 0.16, base});
  AddTube(spot, {-0.5 * size.x(), -0.4 * size.y(), 0.7 * size.z()}, 0, 0.04, size.x());
  AddTube(spot, {-0.45 * size.x(), -0.4 * size.y(), base}, 2, 0.05, size.z() - base);
}

void AddPallet(const Spot& spot, double side) {
  Rng& rng = spot.builder.rng();
  AddBench(spot, {side, side, 0.16});
  const int kind = rng.Index(3);
  if (kind == 0) {
    for (const double x : {-0.25, 0.25}) {
      for (const double y : {-0.25, 0.25}) {
        PlaceInside(spot, {x * side, y * side, 0.17});
        spot.builder.AddCylinder({"drum", Cover(spot), 0.12}, 0.22 * side, 0.8);
      }
    }
    return;
  }
  double z = 0.17;
  for (int i = rng.Index(3) + 1; i > 0; --i) {
    const Vector3d size(
        side * rng.Uniform(0.7, 0.95), side * rng.Uniform(0.7, 0.95), rng.Uniform(0.35, 0.6));
    AddCrate(spot, {0, 0, z}, size, rng.Uniform(-0.08, 0.08));
    z += size.z();
  }
}

void AddColumn(const Spot& spot, double height) {
  PlaceInside(spot, Vector3d::Zero());
  const ShapeBuilder::Finish steel{"column", MaterialOf(spot, "metal"), 0.3};
  for (const double y : {-0.14, 0.14})
    spot.builder.AddBox(steel, {0, y, height / 2}, {0.3, 0.02, height});
  spot.builder.AddBox(steel, {0, 0, height / 2}, {0.02, 0.26, height});
  spot.builder.AddBox({"tape", MaterialOf(spot, "tape")}, {0, 0, 0.5}, {0.34, 0.34, 1});
}

void AddRack(const Spot& spot, const Vector3d& size) {
  Rng& rng = spot.builder.rng();
  PlaceInside(spot, Vector3d::Zero());
  const ShapeBuilder::Finish steel{"rack", MaterialOf(spot, "dark_machine"), 0.2};
  for (const double x : {-0.5, 0.5}) {
    for (const double y : {-0.5, 0.5}) {
      spot.builder.AddBox(steel,
                          {x * (size.x() - 0.08), y * (size.y() - 0.08), size.z() / 2},
                          {0.08, 0.08, size.z()});
    }
  }
  const int num_levels = std::max(2, static_cast<int>(size.z() / 1.1));
  for (int level = 0; level < num_levels; ++level) {
    const double z = 0.15 + level * (size.z() - 0.3) / num_levels;
    PlaceInside(spot, Vector3d::Zero());
    spot.builder.AddBox(
        {"rack", MaterialOf(spot, "boards")}, {0, 0, z}, {size.x(), size.y(), 0.05});
    for (double x = -size.x() / 2 + 0.15; x < size.x() / 2 - 0.5;) {
      const Vector3d crate(rng.Uniform(0.35, 0.75), 0.8 * size.y(), rng.Uniform(0.3, 0.75));
      if (x + crate.x() > size.x() / 2 - 0.1) break;
      if (rng.Uniform() < 0.8)
        AddCrate(spot, {x + crate.x() / 2, 0, z + 0.026}, crate, rng.Uniform(-0.06, 0.06));
      x += crate.x() + rng.Uniform(0.05, 0.25);
    }
  }
}

}  // namespace facet
