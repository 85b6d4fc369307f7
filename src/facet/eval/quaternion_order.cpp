// SPDX-License-Identifier: BSD-2-Clause
#include "facet/eval/quaternion_order.h"

#include <algorithm>
#include <numbers>
#include <vector>

#include "facet/base/median.h"
#include "facet/geometry/so3.h"

namespace facet {
namespace {

// No estimate that is worth judging is as wrong as that, and no right one gains as much from
// another order.
constexpr double kHuge_deg = 5;
constexpr double kExplained = 0.2;

/// What was read as x y z w is w x y z.
Quaterniond WithFirstAsW(const Quaterniond& q) {
  return {q.x(), q.y(), q.z(), q.w()};
}

/// What was read as w x y z is x y z w.
Quaterniond WithLastAsW(const Quaterniond& q) {
  return {q.z(), q.w(), q.x(), q.y()};
}

using Reorder = Quaterniond (*)(const Quaterniond&);

Quaterniond AsRead(const Quaterniond& q) {
  return q;
}

/// Of the rotations between poses a quarter of the trajectory apart.
double MedianError_deg(std::span<const PosePair> pairs, Reorder estimate, Reorder truth) {
  const std::size_t apart = pairs.size() / 4;
  std::vector<double> errors;
  for (std::size_t i = 0; i + apart < pairs.size(); ++i) {
    const PosePair &a = pairs[i], &b = pairs[i + apart];
    const Quaterniond estimated = estimate(a.T_WB.q).conjugate() * estimate(b.T_WB.q);
    const Quaterniond true_one = truth(a.T_GB.q).conjugate() * truth(b.T_GB.q);
    errors.push_back(LogSO3(estimated.conjugate() * true_one).norm());
  }
  return Median(errors).value_or(0) * 180 / std::numbers::pi;
}

}  // namespace

std::optional<SwappedQuaternions> FindSwappedQuaternions(std::span<const PosePair> pairs) {
  SwappedQuaternions found;
  found.as_read_deg = MedianError_deg(pairs, AsRead, AsRead);
  if (found.as_read_deg < kHuge_deg) return std::nullopt;
  found.reordered_deg = found.as_read_deg;
  for (const Reorder reorder : {WithFirstAsW, WithLastAsW}) {
    found.reordered_deg = std::min({found.reordered_deg,
                                    MedianError_deg(pairs, reorder, AsRead),
                                    MedianError_deg(pairs, AsRead, reorder)});
  }
  if (found.reordered_deg > kExplained * found.as_read_deg) return std::nullopt;
  return found;
}

}  // namespace facet
