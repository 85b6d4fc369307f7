// SPDX-License-Identifier: BSD-2-Clause
// Judges planes after a solve: which are known so well that the prior may touch them, and which
// relations do not hold. What is about to leave the window and hangs on a plane that is not known
// so well is cut off before: the prior must not contain it (docs/math.md, section 7, "Membership").
#pragma once

#include <vector>

#include "facet/estimator/factors/factor_noise.h"
#include "facet/estimator/window/sliding_window.h"

namespace facet {

/// 1-sigma below which a plane is known so well that linearising about it for good does no harm.
struct PersistenceLimits {
  double max_normal_deg = 0.5;
  /// Or, for planes of little extent, of the distance at the boundary of their landmarks.
  double max_boundary_m = 0.01;
  double max_offset_m = 0.01;
};

/// Marks the planes that their landmarks and measurements determine to within `limits`;
/// `information` as from WindowSolver::PlaneInformation. What is persistent stays persistent.
void MarkPersistentPlanes(const std::vector<Matrix3d>& information,
                          const PersistenceLimits& limits,
                          SlidingWindow& window);

/// Removes the relations that are violated by more than `max_sigma`. Returns how many.
int DropViolatedRelations(const RelationNoise& noise, double max_sigma, SlidingWindow& window);

/// Cuts the links of leaving landmarks to planes that are not persistent: their rows would freeze
/// the plane where it happens to be.
void CutNonPersistentLinks(const std::vector<char>& leaving_landmarks, SlidingWindow& window);

/// Cuts what leaving frames have measured of planes that are not persistent, for the same reason,
/// and what a frame that stays has measured from the same place: the errors are the same, and at
/// rest they would be counted as new with every keyframe.
void CutMeasurements(const std::vector<char>& leaving_frames, SlidingWindow& window);

/// Removes the relations of leaving planes to planes that are neither persistent nor frozen, for
/// the same reason.
void CutNonPersistentRelations(const std::vector<char>& leaving_planes, SlidingWindow& window);

}  // namespace facet
