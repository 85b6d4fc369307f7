// SPDX-License-Identifier: BSD-2-Clause
// Notices a trajectory whose quaternion columns are in another order than its format has: every
// quaternion is valid then, the positions are right, and only the orientations are nonsense.
#pragma once

#include <optional>
#include <span>

#include "facet/eval/trajectory_error.h"

namespace facet {

/// Median errors of the rotation between two poses of the trajectory [deg].
struct SwappedQuaternions {
  double as_read_deg = 0;
  double reordered_deg = 0;  ///< with the columns in another order
};

/// Whether the estimate's orientations contradict the truth's, but not with the quaternions of one
/// of them in another order: w first instead of last, or the other way round. (Where both have the
/// same world the numbers do not tell which one.) Empty if not, and where too little turns. Needs
/// no alignment.
std::optional<SwappedQuaternions> FindSwappedQuaternions(std::span<const PosePair> pairs);

}  // namespace facet
