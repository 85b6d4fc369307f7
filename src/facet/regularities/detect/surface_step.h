// SPDX-License-Identifier: BSD-2-Clause
// Does a fitted plane bridge two surfaces, one beside the other and a little behind it?
#pragma once

#include <optional>
#include <span>

#include "facet/geometry/plane_fit.h"

namespace facet {

/// A line across a plane: a point lies beyond it when direction . p > position.
struct SurfaceStep {
  Vector3d direction_W = Vector3d::UnitX();  ///< unit, along the plane
  double position_m = 0;

  bool IsBeyond(const Vector3d& p_W) const { return direction_W.dot(p_W) > position_m; }
};

/// The line along which the points jump by at least 3 cm (times `length_scale`, far_surfaces.h)
/// from one plane to another, if two planes explain them clearly better than `fit`. One positive
/// weight per point; `fit` is theirs.
std::optional<SurfaceStep> FindStep(std::span<const Vector3d> points_W,
                                    std::span<const double> weights,
                                    const PlaneFit& fit,
                                    double length_scale);

}  // namespace facet
