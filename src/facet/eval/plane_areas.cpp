// SPDX-License-Identifier: BSD-2-Clause
#include "facet/eval/plane_areas.h"

#include <algorithm>
#include <cmath>

namespace facet {

namespace {

// The truth's own surface lies on the true plane up to rounding, that of a cloud up to its discs.
constexpr double kSamePlace = 0.005;  // [m]
constexpr double kMinCosine = 0.98;   // a disc at an edge leans by some degrees

bool IsPartOf(const SurfacePoint& surface, const TruePlane& plane) {
  return std::abs(plane.n_G.dot(surface.p) - plane.d_G) <= kSamePlace &&
         std::abs(plane.n_G.dot(surface.n)) >= kMinCosine;
}

}  // namespace

std::optional<PlaneAreaFigures> EvaluatePlaneAreas(std::span<const MeshSample> samples_G,
                                                   const TruthSurface& truth,
                                                   std::span<const TruePlane> planes_G) {
  PlaneAreaFigures figures;
  std::size_t num_left_out = 0;
  double sum_of_squares = 0;
  for (const MeshSample& sample : samples_G) {
    const SurfacePoint surface = truth.Closest(sample.p);
    const auto plane = std::ranges::find_if(
        planes_G, [&surface](const TruePlane& candidate) { return IsPartOf(surface, candidate); });
    if (plane == planes_G.end()) continue;
    if (surface.distance > kPlaneAreaLimit) {
      ++num_left_out;
      continue;
    }
    const double distance = plane->n_G.dot(sample.p) - plane->d_G;
    sum_of_squares += distance * distance;
    ++figures.num_samples;
  }
  if (figures.num_samples == 0) return std::nullopt;
  const auto count = static_cast<double>(figures.num_samples);
  figures.rmse_m = std::sqrt(sum_of_squares / count);
  figures.left_out =
      static_cast<double>(num_left_out) / (count + static_cast<double>(num_left_out));
  return figures;
}

}  // namespace facet
