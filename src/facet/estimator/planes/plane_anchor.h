// SPDX-License-Identifier: BSD-2-Clause
// Planes that stay in the window for the whole run are seen from other places later. Their anchors
// follow, so that normal and offset stay nearly independent (docs/math.md, section 7.1).
#pragma once

#include "facet/estimator/window/sliding_window.h"

namespace facet {

/// Moves the anchor of a plane by an exact change of its variables: surface and tangent directions
/// stay; the offset, its delta and the columns of the prior are those of the new anchor. The
/// prior's cost, and gradient and Hessian up to that change of variables, stay what they were.
void MoveAnchor(const Vector3d& anchor_W, int plane, SlidingWindow& window);

/// Moves the anchors that are farther than `max_distance_m` from the mean of the landmarks on their
/// planes to that mean. Planes with fewer than three landmarks stay. Anchors of uneven surfaces
/// follow as soon as they are farther away than the landmarks are from each other, and what the
/// prior knows of the plane is forgotten by as much as another piece of the surface may differ.
/// Returns how many moved.
int FollowLandmarks(double max_distance_m, SlidingWindow& window);

}  // namespace facet
