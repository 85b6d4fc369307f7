// SPDX-License-Identifier: BSD-2-Clause
// Every parameter of the system, composed of the components' own options.
#pragma once

#include <string>

#include "facet/estimator/estimator_options.h"
#include "facet/frontend/frontend_options.h"
#include "facet/mesh/mesh_options.h"
#include "facet/regularities/regularity_options.h"

namespace facet {

struct VioOptions {
  /// The paper's formulations: S (structureless landmarks), SP (landmarks on planes are treated as
  /// in its projection factors), SPR (and planes are variables).
  std::string pipeline = "SPR";
  FrontendOptions frontend;
  EstimatorOptions estimator;
  MeshOptions mesh;
  RegularityOptions regularities;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("pipeline", pipeline, Range{}, "S, SP or SPR");
    v.Group("frontend", frontend);
    v.Group("estimator", estimator);
    v.Group("mesh", mesh);
    v.Group("regularities", regularities);
  }
};

/// What no single value tells: an unknown pipeline, or values that do not fit together. Says which
/// and why, in one line; empty: nothing.
std::string Contradiction(const VioOptions& options);

}  // namespace facet
