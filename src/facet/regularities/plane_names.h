// SPDX-License-Identifier: BSD-2-Clause
// Meshes keep the ids that planes had when their faces were made; since then a plane may have
// turned out to be part of another, or none at all.
#pragma once

#include <span>
#include <vector>

#include "facet/map/plane_record.h"

namespace facet {

/// Replaces the ids of planes that became part of another by that one's, and those that are in no
/// record by -1.
void UseCurrentPlanes(std::span<const PlaneRecord> records, std::vector<int>& plane_ids);

}  // namespace facet
