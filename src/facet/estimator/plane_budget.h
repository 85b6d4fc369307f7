// SPDX-License-Identifier: BSD-2-Clause
// Planes stay for the whole run, so their number must be limited.
#pragma once

#include <vector>

#include "facet/estimator/window.h"

namespace facet {

/// The planes that have to go so that `max_planes` are left: first those on which no landmark of
/// the window lies, then those that landmarks and prior know least of. `information` as from
/// WindowSystem::PlaneInformation for the planes in their present order.
std::vector<PlaneId> ExcessPlanes(const SlidingWindow& window,
                                  const std::vector<Matrix3d>& information,
                                  int max_planes);

}  // namespace facet
