// SPDX-License-Identifier: BSD-2-Clause
// What the tracker keeps of a plane.
#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "facet/map/map_snapshot.h"
#include "facet/regularities/plane_candidate.h"
#include "facet/regularities/plane_support.h"

namespace facet {

/// A plane that was seen; without an id it is tentative and the estimator does not know it.
struct KnownPlane {
  PlaneId id;
  PlaneEstimate estimate;
  PlaneOrientation orientation = PlaneOrientation::kOblique;
  PlaneSupport support;
  int sightings = 0;
  int num_landmarks = 0;
  int num_misfits = 0;  ///< keyframes in a row in which its landmarks did not fit
  Timestamp first_seen, last_seen;
  std::optional<Timestamp> handed_over;
  double recognised_at_m = 0;     ///< how far off it was when it was recognised just now
  std::vector<PlaneId> absorbed;  ///< planes that turned out to be this one

  KnownPlane(const PlaneCandidate& candidate, Timestamp t)
      : support(candidate.plane_W, candidate.centroid_W), first_seen(t), last_seen(t) {}

  bool IsTentative() const { return !id.IsValid(); }

  /// Whether the landmark lies on it, or on a plane that became part of it.
  bool Has(const LandmarkEstimate& landmark) const {
    return landmark.IsOn(id) || std::any_of(absorbed.begin(), absorbed.end(), [&](PlaneId plane) {
             return landmark.IsOn(plane);
           });
  }
};

}  // namespace facet
