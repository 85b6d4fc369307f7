// SPDX-License-Identifier: BSD-2-Clause
#include "facet/eval/plane_error.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "facet/eval/trajectory_error.h"

namespace facet {
namespace {

constexpr double kDegPerRad = 180.0 / std::numbers::pi;

// An estimated plane in the frame of the truth.
struct SupportedPlane {
  Vector3d n_G;
  Vector3d centre_G;  // of the support, on the plane
  double area_m2;
};

struct Difference {
  double angle_deg = 0, offset_m = 0;
};

SupportedPlane IntoTruthFrame(const EstimatedPlane& plane, const TrajectoryAlignment& alignment) {
  const Vector3d on_plane =
      plane.centre_W - (plane.n_W.dot(plane.centre_W) - plane.d_W) * plane.n_W;
  return {alignment.T_GW.q * plane.n_W, alignment * on_plane, plane.area_m2};
}

Difference Compare(const SupportedPlane& estimate, const TruePlane& truth) {
  const double sine = estimate.n_G.cross(truth.n_G).norm();
  const double cosine = std::abs(estimate.n_G.dot(truth.n_G));
  return {std::atan2(sine, cosine) * kDegPerRad,
          std::abs(truth.n_G.dot(estimate.centre_G) - truth.d_G)};
}

bool Matches(const SupportedPlane& estimate,
             const TruePlane& truth,
             const PlaneErrorOptions& options) {
  const Difference difference = Compare(estimate, truth);
  return difference.angle_deg <= options.max_angle_deg &&
         difference.offset_m <= options.max_offset_m &&
         estimate.area_m2 <= options.max_area_ratio * truth.area_m2;
}

// Index of the best free estimate, -1 if none matches.
int BestFree(const TruePlane& truth,
             const std::vector<SupportedPlane>& estimates,
             const std::vector<char>& is_taken,
             const PlaneErrorOptions& options) {
  int best = -1;
  double least = 0;
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    if (is_taken[i] || !Matches(estimates[i], truth, options)) continue;
    const Difference difference = Compare(estimates[i], truth);
    const double score =
        difference.angle_deg / options.max_angle_deg + difference.offset_m / options.max_offset_m;
    if (best >= 0 && score >= least) continue;
    best = static_cast<int>(i);
    least = score;
  }
  return best;
}

std::vector<TruePlane> LargestFirst(std::span<const TruePlane> truth) {
  std::vector<TruePlane> sorted(truth.begin(), truth.end());
  std::stable_sort(sorted.begin(), sorted.end(), [](const TruePlane& a, const TruePlane& b) {
    return a.seen_area_m2 > b.seen_area_m2;
  });
  return sorted;
}

}  // namespace

PlaneError EvaluatePlanes(std::span<const EstimatedPlane> estimated_W,
                          std::span<const TruePlane> truth_G,
                          const TrajectoryAlignment& alignment,
                          const PlaneErrorOptions& options) {
  std::vector<SupportedPlane> estimates;
  for (const EstimatedPlane& plane : estimated_W)
    estimates.push_back(IntoTruthFrame(plane, alignment));
  std::vector<char> is_taken(estimates.size(), 0);
  std::vector<double> angles_deg, offsets_m;
  double area_found = 0, area_to_find = 0;
  PlaneError error;
  error.num_estimated = static_cast<int>(estimates.size());
  for (const TruePlane& truth : LargestFirst(truth_G)) {
    const bool counts = truth.seen_area_m2 >= options.min_seen_area_m2;
    const int i = BestFree(truth, estimates, is_taken, options);
    error.num_true += counts ? 1 : 0;
    area_to_find += counts ? truth.seen_area_m2 : 0;
    if (i < 0) continue;
    is_taken[i] = 1;
    area_found += counts ? truth.seen_area_m2 : 0;
    const Difference difference = Compare(estimates[i], truth);
    angles_deg.push_back(difference.angle_deg);
    offsets_m.push_back(difference.offset_m);
  }
  error.num_matched = static_cast<int>(angles_deg.size());
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    const bool is_on_truth = std::ranges::any_of(
        truth_G, [&](const TruePlane& t) { return Matches(estimates[i], t, options); });
    error.num_duplicates += !is_taken[i] && is_on_truth ? 1 : 0;
  }
  if (area_to_find > 0) error.recall = area_found / area_to_find;
  if (!estimates.empty()) {
    error.precision = static_cast<double>(error.num_matched + error.num_duplicates) /
                      static_cast<double>(estimates.size());
  }
  if (!angles_deg.empty()) {
    error.normal_error_deg_median = Summarize(angles_deg).median;
    error.offset_error_m_median = Summarize(offsets_m).median;
  }
  return error;
}

}  // namespace facet
