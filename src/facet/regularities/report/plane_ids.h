// SPDX-License-Identifier: BSD-2-Clause
// Meshes keep the ids that planes had when their faces were made; since then a plane may have been
// merged into another, or removed.
#pragma once

#include <span>
#include <vector>

#include "facet/map/plane_record.h"

namespace facet {

/// Replaces the ids of planes that were merged into others by the ids of these, and ids that are in
/// no record by -1.
void UseCurrentPlaneIds(std::span<const PlaneRecord> records, std::vector<int>& plane_ids);

}  // namespace facet
