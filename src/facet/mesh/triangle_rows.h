// SPDX-License-Identifier: BSD-2-Clause
// The places of a grid that lie in a triangle, row by row: along a row each side is one bound, so
// no place outside is looked at.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "facet/base/types.h"

namespace facet {

/// Whole numbers from first to last, none if that is less.
struct WholeNumbers {
  int first = 0;
  int last = -1;
};

/// Returns the whole numbers between two bounds and within the limits. The bounds may be anything;
/// for NaN there are none.
inline WholeNumbers WholeNumbersBetween(double low, double high, const WholeNumbers& limits) {
  if (!(low <= high)) return {};
  low = std::max<double>(limits.first, low);
  high = std::min<double>(limits.last, high);
  if (low > high) return {};
  // Within int from here on. std::ceil and std::floor are calls where SSE2 is the most.
  const int near_low = static_cast<int>(low), near_high = static_cast<int>(high);
  return {near_low + (near_low < low ? 1 : 0), near_high - (near_high > high ? 1 : 0)};
}

/// A triangle in the plane of a grid whose places are the whole numbers: inside are those with
/// normal . p >= offset for all three sides.
class TriangleRows {
 public:
  TriangleRows(const std::array<Vector2d, 3>& normals, const std::array<double, 3>& offsets)
      : normals_(normals), offsets_(offsets) {
    for (std::size_t s = 0; s < 3; ++s)
      inverse_x_[s] = 1 / normals[s].x();
  }

  /// The columns inside in a row.
  WholeNumbers Columns(int row, const WholeNumbers& limits) const {
    double low = limits.first, high = limits.last;
    for (std::size_t s = 0; s < 3; ++s) {
      const double missing = offsets_[s] - normals_[s].y() * row;
      const double bound = missing * inverse_x_[s];
      if (normals_[s].x() > 0) {
        low = std::max(low, bound);
      } else if (normals_[s].x() < 0) {
        high = std::min(high, bound);
      } else if (missing > 0) {
        return {};
      }
    }
    return WholeNumbersBetween(low, high, limits);
  }

 private:
  std::array<Vector2d, 3> normals_;
  std::array<double, 3> offsets_;
  std::array<double, 3> inverse_x_{};
};

}  // namespace facet
