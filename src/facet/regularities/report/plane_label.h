// SPDX-License-Identifier: BSD-2-Clause
// Labels of planes in the outputs: floor, table, ceiling, wall. The estimator does not use them.
#pragma once

#include <vector>

#include "facet/map/plane_record.h"

namespace facet {

/// Level planes seen from above: the lowest large ones are floor, those at 0.3 to 1.3 m above it
/// tables; seen from below and higher than 1.8 m above the floor: ceiling. Upright ones of a square
/// metre: walls.
void LabelPlanes(std::vector<PlaneRecord>& planes);

}  // namespace facet
