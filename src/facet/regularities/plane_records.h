// SPDX-License-Identifier: BSD-2-Clause
// What the outside world is told about planes.
#pragma once

#include <span>
#include <vector>

#include "facet/map/plane_record.h"
#include "facet/regularities/known_plane.h"

namespace facet {

/// Each plane as it was when it was known best. Those that were never solved for are left out.
/// `may_unite` says whether the planes are known where the others are (not across a reset of the
/// estimator): then those that touch and agree within their uncertainty, 5 deg and 5 cm half-way
/// between them are one surface, and have one record. Pieces larger than furniture (4 m^2) touch
/// across a gap of the root of the smaller one's area: a ceiling goes on behind a lintel. While a
/// run lasts the estimator waits with that until it knows both well.
/// What has less than 1 m^2 then, and landmarks whose mean square across it is more than half of
/// what is expected (KnownPlane::scatter, kept by EndMisfits), is a row of things and left out, as
/// is what has less than 1 m^2 and a normal that was never known to 2 deg (1-sigma), and what was
/// bent in more than half of the keyframes that could tell (KnownPlane::bends): rough ground, or
/// two surfaces in one. Labels are not set.
std::vector<PlaneRecord> MakeRecords(std::span<const KnownPlane> planes, bool may_unite);

}  // namespace facet
