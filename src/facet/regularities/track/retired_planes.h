// SPDX-License-Identifier: BSD-2-Clause
// Planes that the estimator no longer has. One that it could not keep, because too little was known
// of it, gets its id and its history back when it is detected again.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "facet/regularities/track/tracked_plane.h"

namespace facet {

class RetiredPlanes {
 public:
  /// A plane that the estimator never solved for leaves no trace.
  void Add(TrackedPlane plane);

  /// If the tentative plane is one of them, gives it the history of the retired one, which is
  /// removed here, and returns the id. The same means: within `max_distance_m` at its centroid,
  /// within `max_angle`, and near the retired plane's extent.
  std::optional<PlaneId> Reidentify(double max_angle, double max_distance_m, TrackedPlane& plane);

  /// The estimator started over: earlier planes are not re-identified, because nobody knows where
  /// they are now.
  void StartOver() { num_unreachable_ = planes_.size(); }

  /// Each has TrackedPlane::best.
  std::span<const TrackedPlane> reachable() const {
    return std::span(planes_).subspan(num_unreachable_);
  }
  std::span<const TrackedPlane> unreachable() const {
    return std::span(planes_).first(num_unreachable_);
  }

 private:
  std::vector<TrackedPlane> planes_;
  std::size_t num_unreachable_ = 0;  // the first of them
};

}  // namespace facet
