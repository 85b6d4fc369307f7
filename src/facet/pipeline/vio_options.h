// SPDX-License-Identifier: BSD-2-Clause
// Every parameter of the system, composed of the components' own options.
#pragma once

#include <memory>
#include <span>

#include "facet/base/options.h"
#include "facet/estimator/estimator_options.h"
#include "facet/frontend/frontend_options.h"
#include "facet/loop/loop_options.h"
#include "facet/mesh/mesh_options.h"
#include "facet/regularities/regularity_options.h"

namespace facet {

struct SavedMap;

/// The paper's formulations.
enum class Formulation {
  kS,   ///< landmarks are structureless
  kSP,  ///< and those on planes are treated as in the paper's projection factors
  kSPR  ///< planes are variables, with landmarks, gravity and each other related to them
};

const char* ToString(Formulation formulation);

struct VioOptions {
  Formulation pipeline = Formulation::kSPR;
  /// Off: a calibration that is grossly wrong is not refused (plausibility/calibration_check.h),
  /// and the size of the world not compared with the accelerometer (plausibility/scale_check.h),
  /// nor doubted in the covariances until it is confirmed (plausibility/size_doubt.h).
  bool check_calibration = true;
  FrontendOptions frontend;
  EstimatorOptions estimator;
  MeshOptions mesh;
  RegularityOptions regularities;
  LoopOptions loops;
  // Not parameters: what a run is given besides.
  std::shared_ptr<const SavedMap> known_map;  ///< of runs before; with loops.enabled only
  bool keeps_map = false;                     ///< its result has the map of places

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Choice("pipeline",
             pipeline,
             {"S", "SP", "SPR"},
             "the paper's formulations: no planes, projection factors, planes as variables",
             Audience::kUsers);
    v.Field(
        "check_calibration",
        check_calibration,
        Range{},
        "refuse a calibration that the images contradict; sigmas contain the doubt about sizes");
    v.Group("frontend", frontend);
    v.Group("estimator", estimator);
    v.Group("mesh", mesh);
    v.Group("regularities", regularities);
    v.Group("loops", loops);
  }
};

/// The options of earlier versions that are none any more.
std::span<const RetiredOption> RetiredOptions();

}  // namespace facet
