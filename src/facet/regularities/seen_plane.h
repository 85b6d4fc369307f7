// SPDX-License-Identifier: BSD-2-Clause
// The planes that the estimator has solved for, as the newest camera knows them.
#pragma once

#include <vector>

#include "facet/regularities/known_plane.h"
#include "facet/regularities/plane_gate.h"

namespace facet {

/// Valid for as long as the known plane stays where it is.
struct SeenPlane {
  const KnownPlane* known;
  DistanceUncertainty uncertainty;

  const Plane& plane_W() const { return known->estimate.plane_W; }
};

inline std::vector<SeenPlane> SolvedPlanes(const std::vector<KnownPlane>& planes, const SE3& T_WB) {
  std::vector<SeenPlane> seen;
  for (const KnownPlane& plane : planes) {
    const bool is_solved = !plane.IsTentative() && plane.estimate.covariance(9, 9) > 0;
    if (is_solved) seen.push_back({&plane, DistanceUncertainty(plane.estimate, T_WB)});
  }
  return seen;
}

}  // namespace facet
