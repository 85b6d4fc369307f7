// SPDX-License-Identifier: BSD-2-Clause
#pragma once

#include <optional>
#include <span>

#include "facet/geometry/plane.h"

namespace facet {

/// How far points lie on a curved surface rather than on a plane: rough ground, a board together
/// with a part of the wall that it leans on, things on a shelf.
struct SurfaceCurvature {
  double chi_square = 0;  ///< by which a surface of second order fits them better; 3 dof
  double size_m = 0;      ///< rms between that surface and the plane that fits them best
};

/// `weights` are inverse variances across the plane [1/m^2]. Empty with fewer than ten points and
/// when they do not determine a surface of second order.
std::optional<SurfaceCurvature> FitCurvature(std::span<const Vector3d> points_W,
                                             std::span<const double> weights,
                                             const Vector3d& n_W);

/// Whether that is more than posters on a wall, a sagging floor or lens distortion may cause: more
/// than 6 mm, and significantly.
bool IsCurved(const SurfaceCurvature& curvature);

}  // namespace facet
