// SPDX-License-Identifier: BSD-2-Clause
// Things that stand in halls. Each is built around the origin of its own frame: z up, standing on
// z = 0, its front towards +y; sizes in metres.
#pragma once

#include "facet/render/furniture.h"

namespace facet {

/// A machine in an upright box of this size: a base, one to three housings with faces of about a
/// square metre, a sloped control panel, a tank or a motor, and pipes between them.
void AddMachine(const Spot& spot, const Vector3d& size);
/// A pallet with one to four crates or drums on it. `side`: of the pallet.
void AddPallet(const Spot& spot, double side);
/// A steel column of I section.
void AddColumn(const Spot& spot, double height);
/// A rack of posts and boards with crates. size: width (x), depth (y), height.
void AddRack(const Spot& spot, const Vector3d& size);

}  // namespace facet
