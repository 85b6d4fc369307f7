// SPDX-License-Identifier: BSD-2-Clause
// Planes stay for the whole run, so their number must be limited.
#pragma once

#include <vector>

#include "facet/estimator/window/sliding_window.h"

namespace facet {

/// The planes that have to go so that `max_planes` are left: those that landmarks and prior know
/// least of, whether they are in view or not. A tenth of the budget, at least one, is for planes in
/// view that are not persistent yet: else no new one could ever become better known than those
/// that are there. `information` as from WindowSolver::PlaneInformation for the planes in their
/// present order.
std::vector<PlaneId> ExcessPlanes(const SlidingWindow& window,
                                  const std::vector<Matrix3d>& information,
                                  int max_planes);

}  // namespace facet
