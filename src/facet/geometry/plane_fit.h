// SPDX-License-Identifier: BSD-2-Clause
// Least-squares plane through points, and how well they spread over it.
#pragma once

#include <span>

#include "facet/geometry/plane.h"

namespace facet {

struct PlaneFit {
  Plane plane;
  Vector3d centroid = Vector3d::Zero();
  /// Standard deviations of the points along the plane's principal directions and across it [m].
  double extent_major_m = 0, extent_minor_m = 0, thickness_m = 0;
  Vector3d major_W = Vector3d::UnitX();  ///< unit, along the plane, where they spread most
};

/// `weights` is empty (all equal) or has one positive weight per point. At least one point; fewer
/// than three or collinear points give extent_minor_m = 0 and a meaningless normal.
PlaneFit FitPlane(std::span<const Vector3d> points, std::span<const double> weights = {});

}  // namespace facet
