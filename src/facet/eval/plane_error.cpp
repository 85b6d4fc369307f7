// SPDX-License-Identifier: BSD-2-Clause
#include "facet/eval/plane_error.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>
#include <set>
#include <string>

#include "facet/eval/trajectory_error.h"
#include "facet/geometry/angles.h"
#include "facet/io/errors.h"

namespace facet {
namespace {

constexpr double kDegPerRad = 180.0 / std::numbers::pi;
// Each takes memory until the best are chosen. More are the same planes again and again.
constexpr std::size_t kMaxPairs = 5'000'000;

// An estimated plane in the frame of the truth.
struct SupportedPlane {
  Vector3d n_G;
  Vector3d centre_G;  // of the support, on the plane
  double area_m2;
  double max_offset_m;
};

struct Difference {
  double angle_deg = 0, offset_m = 0;
};

double MaxOffset(const Vector3d& centre_G,
                 std::span<const Vector3d> path_G,
                 const PlaneErrorOptions& options) {
  if (options.max_offset_share <= 0) return options.max_offset_m;
  if (path_G.empty()) return 0;
  double nearest_m2 = std::numeric_limits<double>::infinity();
  for (const Vector3d& p_G : path_G)
    nearest_m2 = std::min(nearest_m2, (p_G - centre_G).squaredNorm());
  return options.max_offset_share * std::sqrt(nearest_m2);
}

SupportedPlane IntoTruthFrame(const EstimatedPlane& plane,
                              const TrajectoryAlignment& alignment,
                              std::span<const Vector3d> path_G,
                              const PlaneErrorOptions& options) {
  const Vector3d on_plane =
      plane.centre_W - (plane.n_W.dot(plane.centre_W) - plane.d_W) * plane.n_W;
  const Vector3d centre_G = alignment * on_plane;
  return {
      alignment.T_GW.q * plane.n_W, centre_G, plane.area_m2, MaxOffset(centre_G, path_G, options)};
}

Difference Compare(const SupportedPlane& estimate, const TruePlane& truth) {
  const double angle_deg = AngleBetween(estimate.n_G, truth.n_G) * kDegPerRad;
  return {std::min(angle_deg, 180 - angle_deg),  // an estimate's normal may point to either side
          std::abs(truth.n_G.dot(estimate.centre_G) - truth.d_G)};
}

// A true plane and what lies flat on it. A poster hides the wall behind it, so seen areas add up;
// the area of the wall includes what is behind the poster.
struct TrueSurface {
  std::vector<TruePlane> planes;  // the largest first
  double area_m2 = 0;             // of the largest
  double seen_area_m2 = 0;        // of all
};

// Cheaper than the angle, and true wherever the angle between the lines is at most this.
bool MayBeParallel(const Vector3d& a, const Vector3d& b, double max_angle_deg) {
  constexpr double kRounding = 1e-9;
  return std::abs(a.dot(b)) >= std::cos(max_angle_deg / kDegPerRad) - kRounding;
}

bool LiesFlatOn(const TruePlane& plane, const TruePlane& larger, const PlaneErrorOptions& options) {
  return larger.area_m2 >= options.min_flat_area_ratio * plane.area_m2 &&
         std::abs(plane.d_G - larger.d_G) <= options.max_flat_offset_m &&
         MayBeParallel(plane.n_G, larger.n_G, options.max_flat_angle_deg) &&
         AngleBetween(plane.n_G, larger.n_G) * kDegPerRad <= options.max_flat_angle_deg;
}

// Groups the planes that were seen into surfaces, the largest first. Planes are compared with the
// largest of a surface only: a pile of thin things is not followed upwards.
std::vector<TrueSurface> GroupSurfaces(std::span<const TruePlane> truth,
                                       const PlaneErrorOptions& options) {
  std::vector<TruePlane> sorted(truth.begin(), truth.end());
  std::ranges::stable_sort(sorted, std::greater{}, &TruePlane::area_m2);
  std::vector<TrueSurface> surfaces;
  for (const TruePlane& plane : sorted) {
    auto surface = std::ranges::find_if(surfaces, [&](const TrueSurface& s) {
      return LiesFlatOn(plane, s.planes.front(), options);
    });
    if (surface == surfaces.end())
      surface = surfaces.insert(surface, TrueSurface{.planes = {}, .area_m2 = plane.area_m2});
    surface->planes.push_back(plane);
    surface->seen_area_m2 += plane.seen_area_m2;
  }
  std::erase_if(surfaces, [&](const TrueSurface& surface) {
    return surface.seen_area_m2 < options.min_visible_area_m2;
  });
  return surfaces;
}

struct Pair {
  std::size_t surface = 0, estimate = 0;
  Difference difference;
  double score = 0;
};

// With the plane of the surface that matches best.
std::optional<Pair> Match(const SupportedPlane& estimate,
                          const TrueSurface& surface,
                          const PlaneErrorOptions& options) {
  if (estimate.area_m2 > options.max_area_ratio * surface.area_m2) return std::nullopt;
  std::optional<Pair> best;
  for (const TruePlane& plane : surface.planes) {
    if (!MayBeParallel(estimate.n_G, plane.n_G, options.max_angle_deg)) continue;
    const Difference difference = Compare(estimate, plane);
    if (difference.angle_deg > options.max_angle_deg) continue;
    if (!(difference.offset_m <= estimate.max_offset_m)) continue;
    const double share =
        estimate.max_offset_m > 0 ? difference.offset_m / estimate.max_offset_m : 0;
    const double score = difference.angle_deg / options.max_angle_deg + share;
    if (!best || score < best->score) best = Pair{.difference = difference, .score = score};
  }
  return best;
}

// All that match, the best first.
std::vector<Pair> MatchingPairs(const std::vector<SupportedPlane>& estimates,
                                const std::vector<TrueSurface>& surfaces,
                                const PlaneErrorOptions& options) {
  std::vector<Pair> pairs;
  for (std::size_t s = 0; s < surfaces.size(); ++s) {
    for (std::size_t e = 0; e < estimates.size(); ++e) {
      std::optional<Pair> pair = Match(estimates[e], surfaces[s], options);
      if (!pair) continue;
      if (pairs.size() == kMaxPairs) {
        throw InputError("planes.csv: its " + std::to_string(estimates.size()) +
                         " planes lie on true surfaces in more than " + std::to_string(kMaxPairs) +
                         " ways; the list must hold each plane once");
      }
      pair->surface = s;
      pair->estimate = e;
      pairs.push_back(*pair);
    }
  }
  std::ranges::stable_sort(pairs, [&](const Pair& a, const Pair& b) {
    if (a.score != b.score) return a.score < b.score;
    return surfaces[a.surface].seen_area_m2 > surfaces[b.surface].seen_area_m2;
  });
  return pairs;
}

std::vector<Pair> OneToOne(const std::vector<Pair>& best_first,
                           std::size_t num_estimates,
                           std::size_t num_surfaces) {
  std::vector<char> is_used(num_estimates, 0), is_found(num_surfaces, 0);
  std::vector<Pair> taken;
  for (const Pair& pair : best_first) {
    if (is_used[pair.estimate] || is_found[pair.surface]) continue;
    is_used[pair.estimate] = is_found[pair.surface] = 1;
    taken.push_back(pair);
  }
  return taken;
}

int CountEstimates(const std::vector<Pair>& pairs) {
  std::set<std::size_t> estimates;
  for (const Pair& pair : pairs)
    estimates.insert(pair.estimate);
  return static_cast<int>(estimates.size());
}

void SetRecall(const std::vector<TrueSurface>& surfaces,
               const std::vector<Pair>& found,
               const PlaneErrorOptions& options,
               PlaneError& error) {
  const auto counts = [&](const TrueSurface& surface) {
    return surface.area_m2 > options.min_area_m2 &&
           surface.seen_area_m2 >= options.min_seen_area_m2;
  };
  double area_found = 0, area_to_find = 0;
  for (const TrueSurface& surface : surfaces) {
    if (!counts(surface)) continue;
    ++error.num_true;
    area_to_find += surface.seen_area_m2;
  }
  for (const Pair& pair : found) {
    if (counts(surfaces[pair.surface])) area_found += surfaces[pair.surface].seen_area_m2;
  }
  if (area_to_find > 0) error.recall = area_found / area_to_find;
}

void SetErrors(const std::vector<Pair>& matched, PlaneError& error) {
  if (matched.empty()) return;
  std::vector<double> angles_deg, offsets_m;
  for (const Pair& pair : matched) {
    angles_deg.push_back(pair.difference.angle_deg);
    offsets_m.push_back(pair.difference.offset_m);
  }
  error.normal_error_deg_median = Summarize(angles_deg).median;
  error.offset_error_m_median = Summarize(offsets_m).median;
}

}  // namespace

PlaneError EvaluatePlanes(std::span<const EstimatedPlane> estimated_W,
                          std::span<const TruePlane> truth_G,
                          const TrajectoryAlignment& alignment,
                          const PlaneErrorOptions& options,
                          std::span<const Vector3d> path_G) {
  std::vector<SupportedPlane> estimates;
  for (const EstimatedPlane& plane : estimated_W)
    estimates.push_back(IntoTruthFrame(plane, alignment, path_G, options));
  const std::vector<TrueSurface> surfaces = GroupSurfaces(truth_G, options);
  const std::vector<Pair> pairs = MatchingPairs(estimates, surfaces, options);
  const std::vector<Pair> matched = OneToOne(pairs, estimates.size(), surfaces.size());

  PlaneError error;
  error.num_estimated = static_cast<int>(estimates.size());
  error.num_matched = static_cast<int>(matched.size());
  const int num_on_truth = CountEstimates(pairs);
  error.num_duplicates = num_on_truth - error.num_matched;
  if (!estimates.empty()) error.precision = static_cast<double>(num_on_truth) / error.num_estimated;
  SetRecall(surfaces, matched, options, error);
  SetErrors(matched, error);
  return error;
}

}  // namespace facet
