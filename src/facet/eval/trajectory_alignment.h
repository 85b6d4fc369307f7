// SPDX-License-Identifier: BSD-2-Clause
// Brings a trajectory into the frame of its ground truth: least squares over positions, closed form
// (Umeyama, PAMI 1991). G is the frame of the ground truth, W the world of the estimate.
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "facet/geometry/se3.h"

namespace facet {

enum class AlignmentKind {
  kSE3,      ///< rotation and translation
  kYawOnly,  ///< rotation about z and translation: both frames know gravity
  kSim3      ///< rotation, translation and scale
};

/// "se3", "yaw", "sim3"; empty for any other word.
std::optional<AlignmentKind> AlignmentKindFromText(std::string_view text);
const char* ToString(AlignmentKind kind);

/// p_G = scale * R_GW p_W + p_GW.
struct TrajectoryAlignment {
  SE3 T_GW;
  double scale = 1;

  Vector3d operator*(const Vector3d& p_W) const { return T_GW.q * (scale * p_W) + T_GW.p; }
};

/// The alignment with the least sum of squared distances |p_G - alignment * p_W|. The spans have
/// the same size, at least one. Where the points leave directions open (all on one line, all in one
/// place) the rest of the rotation is arbitrary and the scale is 1 if nothing moves.
TrajectoryAlignment AlignTrajectory(std::span<const Vector3d> p_W,
                                    std::span<const Vector3d> p_G,
                                    AlignmentKind kind);

}  // namespace facet
