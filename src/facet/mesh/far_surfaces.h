// SPDX-License-Identifier: BSD-2-Clause
// Lengths that suit the surfaces of a room, and what becomes of them for surfaces farther away.
#pragma once

#include <algorithm>

namespace facet {

/// Up to here the lengths of the search for planes (gates, gaps, sides of faces) are what they are
/// set to. Farther away they grow with the distance: as many pixels show a surface that is larger
/// by as much there, and less exactly known [m].
inline constexpr double kFarDistance_m = 3;

/// By what lengths are larger for what is seen from this distance, at least 1.
inline double LengthScale(double distance_m) {
  return std::max(1.0, distance_m / kFarDistance_m);
}

}  // namespace facet
