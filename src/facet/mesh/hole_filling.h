// SPDX-License-Identifier: BSD-2-Clause
// Closes holes in plane surfaces. Elsewhere nobody knows what was not seen.
#pragma once

#include "facet/mesh/triangle_mesh.h"

namespace facet {

/// Adds faces over the holes whose boundary has at most `max_perimeter_m`, lies on one plane within
/// `tolerance_m` (RMS) and continues the surface around it. No vertices are added. Outer borders
/// stay open. The new faces take the plane id that their neighbours share, otherwise -1. Returns
/// the number of holes closed.
int CloseHoles(double max_perimeter_m, double tolerance_m, TriangleMesh& mesh);

}  // namespace facet
