// SPDX-License-Identifier: BSD-2-Clause
#pragma once

#include <cmath>
#include <numbers>

#include "facet/base/types.h"

namespace facet {

/// [rad]; what users read and write is in degrees.
inline constexpr double kDegree = std::numbers::pi / 180;

/// Between two directions of any length, 0 to pi [rad].
inline double AngleBetween(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace facet
