// SPDX-License-Identifier: BSD-2-Clause
// The planes that the estimator has solved for, with how well they are known where the newest
// camera is.
#pragma once

#include <vector>

#include "facet/regularities/track/plane_gate.h"
#include "facet/regularities/track/tracked_plane.h"

namespace facet {

/// Valid for as long as the tracked plane stays where it is.
struct SolvedPlane {
  const TrackedPlane* tracked;
  DistanceUncertainty uncertainty;

  const Plane& plane_W() const { return tracked->estimate.plane_W; }
};

inline std::vector<SolvedPlane> SolvedPlanes(const std::vector<TrackedPlane>& planes,
                                             const SE3& T_WB) {
  std::vector<SolvedPlane> solved;
  for (const TrackedPlane& plane : planes) {
    const bool is_solved = !plane.IsTentative() && plane.estimate.covariance(9, 9) > 0;
    if (is_solved) solved.push_back({&plane, DistanceUncertainty(plane.estimate, T_WB)});
  }
  return solved;
}

}  // namespace facet
