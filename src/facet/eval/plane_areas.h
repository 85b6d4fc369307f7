// SPDX-License-Identifier: BSD-2-Clause
// How flat a mesh is where the truth is a plane.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "facet/eval/mesh_sampling.h"
#include "facet/eval/truth_surface.h"
#include "facet/io/planes_file.h"

namespace facet {

inline constexpr double kPlaneAreaLimit = 0.10;  // [m]

/// Samples of the mesh whose nearest true surface is part of a plane.
struct PlaneAreaFigures {
  std::size_t num_samples = 0;  ///< of them, those within kPlaneAreaLimit of it
  double rmse_m = 0;            ///< root mean square of their distances to the true planes
  double left_out = 0;          ///< share that is farther away: faces across gaps and outliers
};

/// Absent when no sample lies near a plane.
std::optional<PlaneAreaFigures> EvaluatePlaneAreas(std::span<const MeshSample> samples_G,
                                                   const TruthSurface& truth,
                                                   std::span<const TruePlane> planes_G);

}  // namespace facet
