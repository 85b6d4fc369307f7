// SPDX-License-Identifier: BSD-2-Clause
// Every parameter of the system, composed of the components' own options.
#pragma once

#include "facet/estimator/estimator_options.h"
#include "facet/frontend/frontend_options.h"
#include "facet/mesh/mesh_options.h"

namespace facet {

struct VioOptions {
  FrontendOptions frontend;
  EstimatorOptions estimator;
  MeshOptions mesh;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Group("frontend", frontend);
    v.Group("estimator", estimator);
    v.Group("mesh", mesh);
  }
};

}  // namespace facet
