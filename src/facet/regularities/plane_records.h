// SPDX-License-Identifier: BSD-2-Clause
// What the outside world is told about planes.
#pragma once

#include <span>
#include <vector>

#include "facet/map/plane_record.h"
#include "facet/regularities/known_plane.h"

namespace facet {

/// Each plane as it was when it was known best. Left out are those that were never solved for, and
/// those of less than 1 m^2 whose landmarks scatter more than a surface's do: rows of things.
/// `may_unite` says whether the planes are known where the others are (not across a reset of the
/// estimator): then those that touch and agree within their uncertainty, 5 deg and 5 cm half-way
/// between them are one surface, and have one record. What is larger than furniture (4 m^2) touches
/// across a gap as wide as itself: a ceiling goes on behind a lintel. While a run lasts the
/// estimator waits with that until it knows both well. Labels are not set.
std::vector<PlaneRecord> MakeRecords(std::span<const KnownPlane> planes, bool may_unite);

}  // namespace facet
