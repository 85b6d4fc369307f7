// SPDX-License-Identifier: BSD-2-Clause
// What the plane tracker keeps of a plane from its first detection on.
#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "facet/geometry/angles.h"
#include "facet/map/map_snapshot.h"
#include "facet/map/plane_state.h"
#include "facet/regularities/detect/plane_candidate.h"
#include "facet/regularities/track/landmark_count.h"
#include "facet/regularities/track/plane_extent.h"
#include "facet/regularities/track/surface_unevenness.h"

namespace facet {

/// How near to the extent of a plane what belongs to it must be [m].
inline constexpr double kPlaneGrowth_m = 0.5;

/// Planes whose normals differ by more are not the same [rad].
inline constexpr double kSamePlaneAngle = 5 * kDegree;

/// Mean of about the last ten values.
struct RecentMean {
  double mean = 0;
  int num = 0;

  void Add(double value) {
    num = std::min(num + 1, 10);
    mean += (value - mean) / num;
  }
};

/// In how many of the keyframes that could tell the landmarks of a plane lay on a curved surface.
struct CurvatureRecord {
  int num_curved = 0, num_judged = 0;

  void Add(bool is_curved) {
    num_curved += is_curved ? 1 : 0;
    ++num_judged;
  }
  /// Of two planes that are merged, the record of the larger one counts.
  void Keep(double own_area_m2, const CurvatureRecord& other, double other_area_m2) {
    if (other_area_m2 > own_area_m2 && other.num_judged > 0) *this = other;
  }
};

/// How well the landmarks of a plane have fitted it.
struct FitHistory {
  int num_misfits = 0;  ///< keyframes in a row in which they did not
  RecentMean scatter;   ///< across the plane, mean square over what is expected
  CurvatureRecord curvature;
  SurfaceUnevenness unevenness;
};

/// Detections of a plane in the mesh of a keyframe.
struct DetectionHistory {
  int num = 0;          ///< keyframes with one while the plane was tentative
  double offset_m = 0;  ///< distance of the newest keyframe's detection; 0: none
};

struct TimeSpan {
  Timestamp first, last;
};

struct TrackedPlane {
  PlaneState state = PlaneState::kTentative;
  PlaneId id;  ///< invalid while tentative
  PlaneEstimate estimate;
  /// The estimate when its covariance was smallest: what the landmarks of a small plane say fades
  /// when they leave the window one by one. Empty until the estimator has solved for the plane.
  std::optional<PlaneEstimate> best;
  PlaneOrientation orientation = PlaneOrientation::kOblique;
  PlaneExtent extent;
  DetectionHistory detections;
  LandmarkCount landmark_count;
  FitHistory fit;
  TimeSpan seen;
  Timestamp confirmed_at;
  std::vector<PlaneId> merged_ids;  ///< planes that turned out to be the same surface

  TrackedPlane(const PlaneCandidate& candidate, Timestamp t)
      : extent(candidate.plane_W, candidate.centroid_W), seen{t, t} {}

  bool IsTentative() const { return state == PlaneState::kTentative; }

  /// A variable of the estimator that is out of view: only a new detection finds it again.
  bool IsDormant(Timestamp now, double active_s) const {
    return !IsTentative() && ToSeconds(now - seen.last) > active_s;
  }

  /// Whether the landmark lies on it, or on a plane that was merged into it.
  bool Has(const LandmarkEstimate& landmark) const {
    return landmark.IsOn(id) || std::any_of(merged_ids.begin(),
                                            merged_ids.end(),
                                            [&](PlaneId plane) { return landmark.IsOn(plane); });
  }

  /// The plane becomes a variable of the estimator.
  void Confirm(PlaneId new_id, Timestamp now);

  /// Takes the estimator's newest value.
  void Update(const PlaneEstimate& newest);

  /// As the best estimate has it: a plane may turn out to lean.
  void UpdateOrientation(double max_lean_deg);

  /// The other turned out to be the same surface; its extent is taken as lying on `other_plane_W`.
  void Merge(const TrackedPlane& other, const Plane& other_plane_W);
};

inline void TrackedPlane::Confirm(PlaneId new_id, Timestamp now) {
  state = PlaneState::kConfirmed;
  id = estimate.id = new_id;
  confirmed_at = now;
}

inline void TrackedPlane::Update(const PlaneEstimate& newest) {
  estimate = newest;
  state = newest.is_persistent ? PlaneState::kPersistent : PlaneState::kConfirmed;
  const auto variance = [](const PlaneEstimate& e) {
    return e.covariance.block<3, 3>(6, 6).trace();
  };
  const bool is_solved = newest.covariance(9, 9) > 0;
  if (is_solved && (!best || newest.is_persistent || variance(newest) <= variance(*best)))
    best = newest;
}

inline void TrackedPlane::UpdateOrientation(double max_lean_deg) {
  if (!best) return;
  orientation = OrientationOf(best->plane_W.n, best->covariance.block<3, 3>(6, 6), max_lean_deg);
}

inline void TrackedPlane::Merge(const TrackedPlane& other, const Plane& other_plane_W) {
  fit.curvature.Keep(extent.area_m2(), other.fit.curvature, other.extent.area_m2());
  extent.Add(other.extent, other_plane_W);
  landmark_count.Add(other.landmark_count);
  detections.num += other.detections.num;
  seen.first = std::min(seen.first, other.seen.first);
  seen.last = std::max(seen.last, other.seen.last);
  merged_ids.push_back(other.id);
  merged_ids.insert(merged_ids.end(), other.merged_ids.begin(), other.merged_ids.end());
}

}  // namespace facet
