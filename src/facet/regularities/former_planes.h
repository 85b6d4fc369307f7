// SPDX-License-Identifier: BSD-2-Clause
// Planes that the estimator no longer has. One that it could not keep, because little was known of
// it, goes on under its name when it is seen again.
#pragma once

#include <span>
#include <vector>

#include "facet/regularities/known_plane.h"

namespace facet {

class FormerPlanes {
 public:
  /// A plane that was never solved for leaves no trace.
  void Add(KnownPlane plane);

  /// If the plane, which is new to the estimator, is one of them: gives it the name and what was
  /// known of it, and forgets the former one. Near: within `max_distance_m` at its middle, within
  /// `max_angle`, where surface of it was seen.
  bool Recall(double max_angle, double max_distance_m, KnownPlane& plane);

  /// The estimator started over: what was before is not recalled, because nobody knows where it is.
  void StartOver() { num_unreachable_ = planes_.size(); }

  /// Each has KnownPlane::best.
  std::span<const KnownPlane> reachable() const {
    return std::span(planes_).subspan(num_unreachable_);
  }
  std::span<const KnownPlane> unreachable() const {
    return std::span(planes_).first(num_unreachable_);
  }

 private:
  std::vector<KnownPlane> planes_;
  std::size_t num_unreachable_ = 0;  // the first of them
};

}  // namespace facet
