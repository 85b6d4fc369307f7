// SPDX-License-Identifier: BSD-2-Clause
// What users are told about planes.
#pragma once

#include <span>
#include <vector>

#include "facet/map/plane_record.h"
#include "facet/regularities/track/tracked_plane.h"

namespace facet {

/// Each plane with its best estimate. Labels are not set.
///
/// Pieces of one surface get one record if `may_unite`, which must be false across a reset of the
/// estimator, because nobody knows where the planes before it are relative to those after it. Two
/// planes are pieces of one surface if their extents touch and they agree within their uncertainty,
/// 5 deg and 5 cm half-way between them. Pieces larger than furniture (4 m^2) touch across a gap of
/// the root of the smaller one's area: a ceiling goes on behind a lintel. (The estimator itself
/// merges planes only when it has determined both well.)
///
/// Left out are planes that the estimator never solved for; planes below 1 m^2 whose landmarks
/// scatter by more than half of what is expected of a plane (TrackedPlane::scatter): they are rows
/// of things; planes below 1 m^2 whose normal was never known to 2 deg (1-sigma); and planes whose
/// landmarks lay on a curved surface in most keyframes (TrackedPlane::curvature): rough ground, or
/// two surfaces in one.
std::vector<PlaneRecord> MakeRecords(std::span<const TrackedPlane> planes, bool may_unite);

}  // namespace facet
