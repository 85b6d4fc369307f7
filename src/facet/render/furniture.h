// SPDX-License-Identifier: BSD-2-Clause
// Things that stand in rooms. Each is built around the origin of its own frame: z up, standing on
// z = 0, its front towards +y; sizes in metres.
#pragma once

#include "facet/render/shape_builder.h"

namespace facet {

/// Where a thing stands, and the builder that it goes to.
struct Spot {
  ShapeBuilder& builder;
  SE3 T_WO;
};

/// Builds around a point of the thing's frame from then on, turned about z.
void PlaceInside(const Spot& spot, const Vector3d& p_O, double yaw_rad = 0);
/// Index of a material by its name.
int MaterialOf(const Spot& spot, const char* name);

/// A table with things on it. size: width (x), depth (y), height.
void AddTable(const Spot& spot, const Vector3d& size);
/// A bench of rough boards with gaps between them, as of a pallet. size: width (x), depth (y),
/// height.
void AddBench(const Spot& spot, const Vector3d& size);
/// A shelf with an open front, filled with boxes and books.
void AddShelf(const Spot& spot, const Vector3d& size);
/// A desk with a screen at its back, a keyboard and papers. size: width (x), depth (y), height.
void AddDesk(const Spot& spot, const Vector3d& size);
/// A board of 1.1 x 0.75 m on two legs, raised at its back by `slope_rad`.
void AddDrawingTable(const Spot& spot, double slope_rad);
/// A wedge that rises along +x. size: length (x), width (y), height at its end.
void AddRamp(const Spot& spot, const Vector3d& size);
void AddChair(const Spot& spot);
/// One to three cardboard boxes, one on the other, each turned a little.
void AddBoxStack(const Spot& spot, double side);
/// A board that stands on its lower edge and leans back by `lean_rad`. size: width, height.
void AddLeaningBoard(const Spot& spot, const Vector2d& size, int material, double lean_rad);
/// A pot with leaves.
void AddPlant(const Spot& spot, double height);
/// A heap of soft things under a net of coarse mesh: thin strands in front of dark gaps. `size`:
/// width.
void AddNettedHeap(const Spot& spot, double size);
/// Posts and thin bars, along x.
void AddRailing(const Spot& spot, double width, double height);
/// A flat sheet in the plane y = 0 around the origin, seen from +y. size: width, height.
void AddPanel(const Spot& spot, const std::string& label, const Vector2d& size, int material);
/// A flat sheet on the floor, seen from above. size: width (x), length (y).
void AddMat(const Spot& spot, const std::string& label, const Vector2d& size, int material);
/// A pipe along +x from the origin.
void AddPipe(const Spot& spot, double radius, double length);

}  // namespace facet
