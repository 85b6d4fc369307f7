// SPDX-License-Identifier: BSD-2-Clause
#pragma once

#include <optional>
#include <span>

#include "facet/geometry/plane.h"

namespace facet {

/// How far points lie on a bent surface rather than on a plane: rough ground, a board with a part
/// of the wall that it leans on, things on a shelf.
struct SurfaceBend {
  double chi_square = 0;  ///< by which a surface of second order fits them better; 3 dof
  double size_m = 0;      ///< rms between that surface and the plane that fits them best
};

/// `weights` are inverse variances across the plane [1/m^2]. Absent with fewer than ten points and
/// when the fit is of no use.
std::optional<SurfaceBend> FitBend(std::span<const Vector3d> points_W,
                                   std::span<const double> weights,
                                   const Vector3d& n_W);

/// Whether that is more than posters on a wall, a sagging floor or a lens may have: more than 6 mm,
/// and more than `max_chi_square`.
bool IsBent(const SurfaceBend& bend, double max_chi_square);

}  // namespace facet
