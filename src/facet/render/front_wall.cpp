// SPDX-License-Identifier: BSD-2-Clause
#include "facet/render/front_wall.h"

#include <algorithm>
#include <cmath>

#include "facet/geometry/so3.h"

namespace facet {
namespace {

/// A frame that juts out, the pane in it, and a sill below. `p_O`: middle of the window.
void AddWindow(const Spot& spot, const Vector3d& p_O, const Vector2d& size) {
  constexpr double kFrame = 0.09, kDepth = 0.12;
  const ShapeBuilder::Finish frame{"frame", MaterialOf(spot, "smooth_render"), 0.5};
  PlaceInside(spot, p_O);
  for (const double side : {-1.0, 1.0}) {
    spot.builder.AddBox(frame,
                        {side * (size.x() + kFrame) / 2, kDepth / 2, 0},
                        {kFrame, kDepth, size.y() + 2 * kFrame});
    spot.builder.AddBox(
        frame, {0, kDepth / 2, side * (size.y() + kFrame) / 2}, {size.x(), kDepth, kFrame});
  }
  spot.builder.AddBox({"sill", MaterialOf(spot, "concrete"), 0.5},
                      {0, 0.12, -size.y() / 2 - kFrame - 0.04},
                      {size.x() + 0.4, 0.24, 0.08});
  spot.builder.AddPatch({"window", MaterialOf(spot, "glass"), 0.5},
                        {size.x() / 2, 0.01, -size.y() / 2},
                        {-size.x(), 0, 0},
                        {0, 0, size.y()});
}

void AddDoor(const Spot& spot, double x) {
  PlaceInside(spot, {x, 0, 0});
  const int stone = MaterialOf(spot, "concrete");
  spot.builder.AddPatch(
      {"door", MaterialOf(spot, "boards"), 0.4}, {0.7, 0.02, 0.3}, {-1.4, 0, 0}, {0, 0, 2.3});
  for (const double side : {-1.0, 1.0})
    spot.builder.AddBox({"frame", stone, 0.4}, {side * 0.8, 0.1, 1.45}, {0.2, 0.2, 2.5});
  spot.builder.AddBox({"frame", stone, 0.4}, {0, 0.3, 2.75}, {2, 0.6, 0.15});
  for (int step = 0; step < 2; ++step) {
    const double depth = 0.9 - 0.35 * step;
    spot.builder.AddBox(
        {"step", stone, 0.4}, {0, depth / 2, 0.075 + 0.15 * step}, {2.2, depth, 0.15});
  }
}

void AddBalcony(const Spot& spot, const Vector3d& p_O, double width) {
  PlaceInside(spot, p_O);
  spot.builder.AddBox(
      {"balcony", MaterialOf(spot, "concrete"), 0.4}, {0, 0.6, 0}, {width, 1.2, 0.16});
  const Spot front{spot.builder,
                   spot.T_WO * SE3(Quaterniond::Identity(), p_O + Vector3d(0, 1.15, 0.08))};
  AddRailing(front, width, 1);
}

void AddWindows(const Spot& spot, const Vector3d& size, const FrontStyle& style) {
  Rng& rng = spot.builder.rng();
  const int num_storeys = std::max(1, static_cast<int>(size.z() / style.storey_m));
  const int num_columns = std::max(1, static_cast<int>((size.x() - 1) / style.window_pitch));
  const double pitch = size.x() / num_columns;
  const Vector2d window(std::min(0.55 * pitch, rng.Uniform(1.1, 1.6)), rng.Uniform(1.3, 1.8));
  const int door = num_columns / 2;
  for (int storey = 0; storey < num_storeys; ++storey) {
    for (int column = 0; column < num_columns; ++column) {
      const double x = (column + 0.5) * pitch - size.x() / 2;
      const double z = storey * style.storey_m + 0.55 * style.storey_m;
      if (storey == 0 && column == door) {
        AddDoor(spot, x);
        continue;
      }
      AddWindow(spot, {x, 0, z}, window);
      if (style.has_balconies && storey > 0 && column % 3 == 1)
        AddBalcony(spot, {x, 0, storey * style.storey_m + 0.1}, 2.4);
    }
  }
}

}  // namespace

void AddBuilding(const Spot& spot, const Vector3d& size, const FrontStyle& style) {
  PlaceInside(spot, Vector3d::Zero());
  spot.builder.AddBox({"wall", style.wall, 0.6},
                      {0, -size.y() / 2, size.z() / 2 - 0.1},
                      {size.x(), size.y(), size.z() + 0.2});
  const int stone = MaterialOf(spot, "concrete");
  spot.builder.AddBox({"plinth", stone, 0.5}, {0, 0.05, 0.35}, {size.x() + 0.1, 0.1, 0.7});
  if (style.has_ledges) {
    const int num_storeys = std::max(1, static_cast<int>(size.z() / style.storey_m));
    for (int storey = 1; storey < num_storeys; ++storey) {
      spot.builder.AddBox(
          {"ledge", stone, 0.5}, {0, 0.1, storey * style.storey_m}, {size.x() + 0.2, 0.2, 0.18});
    }
    spot.builder.AddBox(
        {"ledge", stone, 0.5}, {0, 0.2, size.z() - 0.15}, {size.x() + 0.4, 0.5, 0.3});
  }
  for (const double side : {-1.0, 1.0}) {  // rain pipes
    PlaceInside(spot, {side * (size.x() / 2 - 0.4), 0.12, 0});
    spot.builder.AddCylinder({"pipe", MaterialOf(spot, "metal"), 0.4}, 0.06, size.z());
  }
  if (style.window_pitch > 0) AddWindows(spot, size, style);
}

void AddTree(const Spot& spot, double height) {
  Rng& rng = spot.builder.rng();
  PlaceInside(spot, {0, 0, -0.1});
  spot.builder.AddCylinder(
      {"trunk", MaterialOf(spot, "stone"), 0.15}, 0.035 * height, 0.5 * height);
  for (int i = 0; i < 5; ++i) {
    const double angle = 1.26 * i + rng.Uniform(-0.3, 0.3), reach = (i == 0 ? 0 : 0.16) * height;
    const Vector3d p_O(reach * std::cos(angle),
                       reach * std::sin(angle),
                       (i == 0 ? 0.8 : rng.Uniform(0.5, 0.75)) * height);
    PlaceInside(spot, p_O);
    spot.builder.AddFoliage({"tree", MaterialOf(spot, "leaf")}, 0.2 * height, 260);
  }
}

void AddCar(const Spot& spot) {
  Rng& rng = spot.builder.rng();
  const char* const kPaints[] = {"dark_machine", "machine", "dark_machine", "smooth_render"};
  const int paint = MaterialOf(spot, kPaints[rng.Index(4)]), dark = MaterialOf(spot, "dark");
  const int glass = MaterialOf(spot, "glass");
  PlaceInside(spot, Vector3d::Zero());
  spot.builder.AddBox({"car", paint}, {0, 0, 0.62}, {4.2, 1.7, 0.6});
  spot.builder.AddBox({"car", paint}, {-0.15, 0, 1.18}, {2.1, 1.5, 0.55});
  for (const double side : {-1.0, 1.0}) {
    spot.builder.AddPatch({"car window", glass},
                          {-0.15 - side * 0.95, side * 0.755, 0.96},
                          {side * 1.9, 0, 0},
                          {0, 0, -0.42});
  }
  for (const double x : {-1.3, 1.3}) {
    for (const double y : {-0.86, 0.66}) {
      spot.builder.Place(spot.T_WO *
                         SE3(ExpSO3(Vector3d(-std::numbers::pi / 2, 0, 0)), {x, y, 0.32}));
      spot.builder.AddCylinder({"wheel", dark, 0.1}, 0.32, 0.2);
    }
  }
}

void AddPole(const Spot& spot, double height, bool has_sign) {
  PlaceInside(spot, {0, 0, -0.05});
  spot.builder.AddCylinder(
      {"pole", MaterialOf(spot, "metal"), 0.3}, has_sign ? 0.035 : 0.07, height);
  if (has_sign) {
    const SE3 T_OS(Quaterniond::Identity(), {0, 0.05, height - 0.5});
    AddPanel({spot.builder, spot.T_WO * T_OS},
             "sign",
             {0.7, 0.7},
             spot.builder.materials().RandomPicture(spot.builder.rng()));
  } else {
    PlaceInside(spot, {0, 0.5, height - 0.1});
    spot.builder.AddBox(
        {"pole", MaterialOf(spot, "dark_machine"), 0.2}, {0, 0, 0}, {0.25, 1.1, 0.12});
  }
}

}  // namespace facet
