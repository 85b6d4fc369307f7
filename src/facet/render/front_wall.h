// SPDX-License-Identifier: BSD-2-Clause
// What stands in a yard or a street. Each thing is built around the origin of its own frame: z up,
// standing on z = 0, its front towards +y; sizes in metres.
#pragma once

#include "facet/render/furniture.h"

namespace facet {

/// How the front of a building looks.
struct FrontStyle {
  int wall = 0;             ///< material
  double storey_m = 3.2;    ///< height of one
  double window_pitch = 3;  ///< between the middles of windows; 0: no windows
  bool has_ledges = true;   ///< between storeys, and a cornice
  bool has_balconies = false;
};

/// A building with windows, ledges and a door in its front. size: width (x), depth (-y), height;
/// the front is in the plane y = 0.
void AddBuilding(const Spot& spot, const Vector3d& size, const FrontStyle& style);
void AddTree(const Spot& spot, double height);
/// 4.2 x 1.7 x 1.45 m, along x.
void AddCar(const Spot& spot);
/// A lamp post or, with a sign on it, a traffic sign.
void AddPole(const Spot& spot, double height, bool has_sign);

}  // namespace facet
