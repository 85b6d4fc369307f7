// SPDX-License-Identifier: BSD-2-Clause
// Judges planes after a solve: which are known so well that the prior may touch them, and which
// relations do not hold. What is about to leave the window and hangs on a plane that is not known
// so well is cut off before: the prior must not contain it (docs/math.md, section 7, "Membership").
#pragma once

#include <vector>

#include "facet/estimator/factors/factor_noise.h"
#include "facet/estimator/window/sliding_window.h"

namespace facet {

/// Marks the planes that their landmarks and sightings determine well enough
/// (PlaneOptions); `information` as from
/// WindowSolver::PlaneInformation. What is settled stays settled.
void MarkSettledPlanes(const std::vector<Matrix3d>& information,
                       const PlaneOptions& options,
                       SlidingWindow& window);

/// Removes the relations that are violated by more than `max_sigma`. Returns how many.
int DropViolatedRelations(const RelationNoise& noise, double max_sigma, SlidingWindow& window);

/// Cuts the links of leaving landmarks to planes that are not settled: their rows would freeze the
/// plane where it happens to be.
void CutUnsettledLinks(const std::vector<char>& leaving_landmarks, SlidingWindow& window);

/// Cuts what leaving frames have sighted of planes that are not settled, for the same reason, and
/// what a frame that stays has sighted from the same place: the errors are the same, and at rest
/// they would be counted as new with every keyframe.
void CutSightings(const std::vector<char>& leaving_frames, SlidingWindow& window);

/// Removes the relations of leaving planes to planes that are neither settled nor frozen, for the
/// same reason.
void CutUnsettledRelations(const std::vector<char>& leaving_planes, SlidingWindow& window);

}  // namespace facet
