// SPDX-License-Identifier: BSD-2-Clause
// What the search for regularities finds after a keyframe.
#pragma once

#include "facet/map/plane_assignments.h"
#include "facet/mesh/mesh_regularities.h"

namespace facet {

struct RegularityResult {
  PlaneAssignments assignments;  ///< for the estimator, before its next keyframe
  MeshRegularities mesh;         ///< for the mesh in which they were found
};

}  // namespace facet
