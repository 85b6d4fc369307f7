// SPDX-License-Identifier: BSD-2-Clause
// What the tracker keeps of a plane.
#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "facet/map/map_snapshot.h"
#include "facet/regularities/member_count.h"
#include "facet/regularities/plane_candidate.h"
#include "facet/regularities/plane_support.h"

namespace facet {

/// How near to its known surface what belongs to a plane is [m].
inline constexpr double kPlaneGrowth_m = 0.5;

/// Of the last ten or so values.
struct RecentMean {
  double mean = 0;
  int num = 0;

  void Add(double value) {
    num = std::min(num + 1, 10);
    mean += (value - mean) / num;
  }
};

/// In how many of the keyframes that could tell a plane's landmarks lay on a bent surface.
struct Bends {
  int num_bent = 0, num_judged = 0;

  void Add(bool is_bent) {
    num_bent += is_bent ? 1 : 0;
    ++num_judged;
  }
  /// The verdict on the larger of two surfaces that are one.
  void Keep(double own_area_m2, const Bends& other, double its_area_m2) {
    if (its_area_m2 > own_area_m2 && other.num_judged > 0) *this = other;
  }
};

/// A plane that was seen; without an id it is tentative and the estimator does not know it.
struct KnownPlane {
  PlaneId id;
  PlaneEstimate estimate;
  /// The estimate when it was known best: what the landmarks of a small plane say fades when they
  /// leave one by one. Empty until the estimator has solved for the plane.
  std::optional<PlaneEstimate> best;
  PlaneOrientation orientation = PlaneOrientation::kOblique;
  PlaneSupport support;
  int times_seen = 0;  ///< keyframes that showed it while it was tentative
  MemberCount members;
  int num_misfits = 0;  ///< keyframes in a row in which its landmarks did not fit
  RecentMean scatter;   ///< of its landmarks across it, mean square over what is expected
  Bends bends;
  Timestamp first_seen, last_seen;
  std::optional<Timestamp> handed_over;
  double recognised_at_m = 0;     ///< how far off it was when it was recognised just now
  std::vector<PlaneId> absorbed;  ///< planes that turned out to be this one

  KnownPlane(const PlaneCandidate& candidate, Timestamp t)
      : support(candidate.plane_W, candidate.centroid_W), first_seen(t), last_seen(t) {}

  /// Takes the estimator's newest word.
  void Update(const PlaneEstimate& newest);

  /// The other turned out to be this one. Its surface is taken as lying on `its_plane_W`.
  void Absorb(const KnownPlane& other, const Plane& its_plane_W);

  /// As the estimator knows it by now: it may turn out to lean.
  void SetOrientation(double max_lean_deg);

  bool IsTentative() const { return !id.IsValid(); }

  /// Whether the landmark lies on it, or on a plane that became part of it.
  bool Has(const LandmarkEstimate& landmark) const {
    return landmark.IsOn(id) || std::any_of(absorbed.begin(), absorbed.end(), [&](PlaneId plane) {
             return landmark.IsOn(plane);
           });
  }
};

inline void KnownPlane::Update(const PlaneEstimate& newest) {
  estimate = newest;
  const auto variance = [](const PlaneEstimate& e) {
    return e.covariance.block<3, 3>(6, 6).trace();
  };
  const bool is_solved = newest.covariance(9, 9) > 0;
  if (is_solved && (!best || newest.is_settled || variance(newest) <= variance(*best)))
    best = newest;
}

inline void KnownPlane::SetOrientation(double max_lean_deg) {
  if (!best) return;
  orientation = OrientationOf(best->plane_W.n, best->covariance.block<3, 3>(6, 6), max_lean_deg);
}

inline void KnownPlane::Absorb(const KnownPlane& other, const Plane& its_plane_W) {
  bends.Keep(support.area_m2(), other.bends, other.support.area_m2());
  support.Add(other.support, its_plane_W);
  members.Add(other.members);
  times_seen += other.times_seen;
  first_seen = std::min(first_seen, other.first_seen);
  last_seen = std::max(last_seen, other.last_seen);
  absorbed.push_back(other.id);
  absorbed.insert(absorbed.end(), other.absorbed.begin(), other.absorbed.end());
}

}  // namespace facet
