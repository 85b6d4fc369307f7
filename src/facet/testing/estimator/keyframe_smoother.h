// SPDX-License-Identifier: BSD-2-Clause
// Fixed-lag smoothing of keyframes alone: what VioEstimator does, without its start and its
// exceptions, and with planes that are told the truth. For tests that want to look into the prior.
#pragma once

#include <map>

#include "facet/estimator/solver/window_solver.h"
#include "facet/estimator/window/marginalization_plan.h"
#include "facet/imu/imu_buffer.h"
#include "facet/sim/feature_simulator.h"
#include "facet/testing/estimator/test_window.h"

namespace facet::testing {

enum class SmootherPlanes {
  kNone,
  kKept,      ///< one for each true surface, for the whole run
  kMeasured,  ///< the same, and every keyframe that sees one measures it
  kRelated,   ///< related to each other and to gravity, re-anchored, one of them replaced at times
};

class KeyframeSmoother {
 public:
  /// With `first_estimates` false the prior follows the estimate, and with it all Jacobians.
  KeyframeSmoother(const SimulatedRun& run, bool first_estimates, SmootherPlanes planes);

  /// The i-th frame of the run, which becomes a keyframe.
  void Process(std::size_t i, Rng& rng);

  const SlidingWindow& window() const { return window_; }
  int num_marginalizations() const { return num_marginalizations_; }
  int num_moved_anchors() const { return num_moved_anchors_; }
  int num_relations_used() const { return num_relations_used_; }
  int num_measurements() const { return num_measurements_; }

 private:
  void AppendFrame(std::size_t i, Rng& rng);
  PlaneId PlaneOf(LandmarkId landmark);
  PlaneId SurfaceOf(PlaneId plane) const;
  void TieToSurfaces();
  void MeasurePlanes(Rng& rng);
  void RelatePlanes();
  void Relate(PlaneId first, PlaneId plane, bool is_flat);
  void ReplaceAPlane(std::size_t i, MarginalizationPlan& plan);
  void FollowEstimate();

  const SimulatedRun& run_;
  bool first_estimates_;
  SmootherPlanes planes_;
  ImuBuffer imu_;
  SlidingWindow window_;
  WindowSolver solver_;
  FactorNoise noise_;
  FrameGeometry geometry_;
  std::map<std::int64_t, std::int64_t> generation_;
  int num_marginalizations_ = 0, num_moved_anchors_ = 0, num_relations_used_ = 0;
  int num_measurements_ = 0;
};

}  // namespace facet::testing
