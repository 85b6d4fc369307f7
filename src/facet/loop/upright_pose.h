// SPDX-License-Identifier: BSD-2-Clause
// The pose of a camera whose tilt is known, from points in the world and where they are seen:
// heading and position, four degrees of freedom.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "facet/geometry/se3.h"

namespace facet {

/// Turns about the world's vertical, then moves.
struct UprightPose {
  double yaw_rad = 0;
  Vector3d p = Vector3d::Zero();

  Vector3d operator*(const Vector3d& x) const;
  UprightPose operator*(const UprightPose& b) const;
  UprightPose Inverse() const;
  SE3 ToSE3() const;
};

/// A point in an upright frame A and the direction in which it is seen from the origin of another
/// upright frame B, in B.
struct SeenPoint {
  Vector3d p_A = Vector3d::Zero();
  Vector3d bearing_B = Vector3d::UnitZ();  ///< of unit length
};

/// Every T_BA (at most two) that has both points where they are seen, in front.
std::vector<UprightPose> UprightPosesFromTwo(const SeenPoint& first, const SeenPoint& second);

/// The T_BA that has the most points within `max_angle_rad` of where they are seen, and which ones.
/// Deterministic. Empty where no two points give one.
struct UprightConsensus {
  UprightPose T_BA;
  std::vector<int> inliers;
};
std::optional<UprightConsensus> FindUprightPose(std::span<const SeenPoint> points,
                                                double max_angle_rad,
                                                int num_trials);

}  // namespace facet
