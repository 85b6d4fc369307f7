// SPDX-License-Identifier: BSD-2-Clause
// What becomes of planes in the window, keyframe after keyframe: they are announced, come into
// force, are judged, and are ended.
#pragma once

#include <span>
#include <vector>

#include "facet/estimator/factors/factor_noise.h"
#include "facet/estimator/planes/plane_evidence.h"
#include "facet/estimator/window/frame_geometry.h"
#include "facet/estimator/window/marginalization_plan.h"
#include "facet/estimator/window/window_snapshot.h"
#include "facet/map/plane_assignments.h"

namespace facet {

/// Holds what waits and what is remembered; the planes themselves are in the window. Not
/// thread-safe.
class PlaneLifecycle {
 public:
  explicit PlaneLifecycle(const EstimatorOptions& options)
      : options_(options.planes), convert_back_(options.projection.convert_back) {}

  /// Waits for the next keyframe; calls before it add up.
  void Announce(const PlaneAssignments& assignments);

  /// Before the solve: what was announced comes into force. Of all that was said landmarks leave
  /// planes first, then they join; planes with too little support go again. `geometry` must be up
  /// to date.
  void TakeEffect(const FactorNoise& noise, const FrameGeometry& geometry, SlidingWindow& window);

  /// After the solve: landmarks on planes where they do not belong leave them. True if they were
  /// so many that they bent the window: it has to be weighed and solved again without them, from
  /// where it was (a few iterations do not lead back from far off), before their pull is frozen or
  /// good observations look wrong. `geometry` must be up to date.
  bool DetachWrongLandmarks(const FactorNoise& noise,
                            const FrameGeometry& geometry,
                            SlidingWindow& window) const;

  /// After the solve: which planes are persistent or too many, which relations do not hold.
  /// `information` and `covariances` as from WindowSolver.
  void Judge(const std::vector<Matrix3d>& information,
             const std::vector<Matrix<9, 9>>& covariances,
             const FactorNoise& noise,
             SlidingWindow& window);

  /// After the removal of outliers, without which vision places some landmarks elsewhere: those
  /// that no longer fit their plane leave it. `geometry` must be up to date.
  void FollowOutlierRemoval(const FactorNoise& noise,
                            const FrameGeometry& geometry,
                            SlidingWindow& window) const;

  /// Of the planes that were ended, those that the prior does not know go at once ...
  void RemoveRetired(SlidingWindow& window);
  /// ... and the others are marginalised.
  void RetireIn(const SlidingWindow& window, MarginalizationPlan& plan);

  /// Before the plan is carried out: cuts off what the prior must not contain, and remembers what
  /// it takes up.
  void CutNonPersistent(const MarginalizationPlan& plan, SlidingWindow& window);

  /// After the newest keyframe's solve.
  std::span<const PlaneCovariance> covariances() const { return covariances_; }

 private:
  void KeepCovariances(const std::vector<Matrix<9, 9>>& covariances, const SlidingWindow& window);

  PlaneOptions options_;
  bool convert_back_;
  PlaneAssignments waiting_;
  std::vector<PlaneId> retired_;
  std::vector<PlaneCovariance> covariances_;
  PlaneEvidence evidence_;
};

}  // namespace facet
