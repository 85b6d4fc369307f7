// SPDX-License-Identifier: BSD-2-Clause
// What known planes say of a triangle of the horizon mesh, as plain data: who finds planes knows
// the mesh, the mesh does not know planes.
#pragma once

namespace facet {

struct FaceStanding {
  int plane_id = -1;       ///< all corners lie on this plane, over or beside its known surface
  bool is_bridge = false;  ///< leads from a plane to something else, through free space
};

}  // namespace facet
